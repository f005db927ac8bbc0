// SPDX-License-Identifier: Apache-2.0
// The gateway as a Modbus server of its own, so that a PLC can watch it with the protocol that it
// already has: 43/14 identification, 08 counters, 04 input registers with the health of every bus
// and device.
//
// Input registers have 16 bits; 32-bit counters take two, high word first, and wrap. Buses and
// devices are numbered from 0 in the order of the configuration. docs/status.md has the table of
// all registers. Reserved ones are 0, other addresses exception 02.
#pragma once

#include <cstdint>
#include <vector>

#include "gateway/bus_set.hpp"
#include "gateway/clients/sessions.hpp"
#include "modbus/pdu.hpp"

namespace mbgate::gateway {

/// What all clients together have sent.
struct ClientCounters {
  std::uint64_t requests = 0;
  std::uint64_t foreign_adus = 0;  ///< skipped: the protocol identifier was not 0
  std::uint64_t framing_lost = 0;
};

/// The state of the gateway at an instant.
struct StatusView {
  const Settings& settings;
  const BusSet& all;
  const Sessions& sessions;
  const ClientCounters& counters;
  bus::Instant started;
  bus::Instant now;
  std::vector<BusId> buses = settings.written_buses();
  std::vector<Settings::WrittenDevice> devices = settings.written_devices();
};

class StatusUnit {
 public:
  struct Answer {
    modbus::Pdu pdu;
    bool clear_counters = false;  ///< 08/0A: all counters are to be cleared, its own too
  };
  /// Answers everything; what the gateway itself does not do gets exception 01.
  Answer answer(const modbus::Pdu& request, const StatusView& view);
  void clear_counters() { requests_ = 0; }
  /// Does it read another table than that of the status? It gets 01, and the journal says where.
  [[nodiscard]] static bool is_elsewhere(const modbus::Pdu& request) {
    return request.function() >= 0x01 && request.function() <= 0x03;
  }
  static constexpr const char* kWhere =
      "denied: the unit is the gateway itself, with its status in input registers (function 4)";

 private:
  [[nodiscard]] Answer diagnose(const modbus::Pdu& request, const StatusView& view) const;

  std::uint16_t requests_ = 0;  ///< CPT4, the server message count (Serial Line V1.02, appendix A)
};

}  // namespace mbgate::gateway
