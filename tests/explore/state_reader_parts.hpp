// SPDX-License-Identifier: Apache-2.0
// How the state of the machine (state_reader.hpp) is read, class by class. Each class is taken
// apart whole: a member that is added does not compile until somebody has said here what it means.
// What is left out is left out by name, with the reason why it decides nothing.
//
// The reasons hold for small worlds: one RTU line that is never lost, no guards, nothing read
// ahead, the same settings all the time, less than a minute of virtual time. What they rest on and
// can be seen here is asserted.
#pragma once

#include "explore/opened_machine.hpp"
#include "explore/state_hash.hpp"

namespace mbgate::explore {

struct StateReader {
  using Hash = StateHash;

  static void read(gateway::Gateway& gateway, Hash& hash);

 private:
  /// What of a bus says how far back is looked.
  struct Sight {
    bool stop_waits;       ///< what was before it waited counts for it too
    bool may_be_offline;   ///< any of its devices
    Duration frame_slack;  ///< that an answer may pause
  };

  // state_reader_gateway.cpp
  static void read(gateway::Clients& clients, gateway::Gateway& gateway, Hash& hash);
  static void read(const gateway::ClientSession& session, gateway::Gateway& gateway, Hash& hash);
  static void read(const gateway::Exchange& exchange, gateway::Gateway& gateway, Hash& hash);
  static void read(const routing::Plan& plan, Hash& hash);

  // state_reader_bus.cpp
  static void read(bus::Bus& bus, gateway::Gateway& gateway, Hash& hash);
  static void read(const bus::BusQueue& queue, gateway::Gateway& gateway, Hash& hash);
  static void read(const bus::DeviceTable& devices, const Sight& sight, Hash& hash);
  static void read(const bus::DeviceEntry& entry, const Sight& sight, Hash& hash);
  static void read(const bus::DeviceHealth& health, const drive::DeviceTiming& timing, Hash& hash);
  static void read(const bus::Hold& hold, const drive::DeviceTiming& timing, Hash& hash);
  static void read(const bus::ReadCache& cache, Duration age, Hash& hash);
  static void read(const bus::LastSent& sent, const bus::BusSettings& settings, const Sight& sight,
                   Hash& hash);
  static void read(const bus::LinkState& link, Hash& hash);
  static void read_leader(const bus::Job& leader, const bus::DeviceTable& devices,
                          gateway::Gateway& gateway, Hash& hash);
  static void read(const bus::Job* job, gateway::Gateway& gateway, Hash& hash);
  static void read(const bus::Transaction& transaction, Hash& hash);

  // state_reader_line.cpp
  static void read(const bus::LineDiscipline& line, const Sight& sight, Hash& hash);
  static void read(const bus::SerialDiscipline& line, const Sight& sight, Hash& hash);
  static void read(const bus::Echo& echo, bool is_running, Hash& hash);
  static void read(const bus::RtuFramer& framer, Hash& hash);
  static void read(const bus::ReceivedBytes& received, Duration reach, Hash& hash);
  static void read(const bus::CutFrame& cut, bool is_last, Hash& hash);
};

}  // namespace mbgate::explore
