// SPDX-License-Identifier: Apache-2.0
// The gateway as a Modbus server of its own, so that a PLC can watch it with the protocol that it
// already has: 43/14 identification, 08 counters, 04 input registers with the health of every bus
// and device.
//
// Input registers have 16 bits; 32-bit counters take two, high word first, and wrap. Buses and
// devices are numbered from 0 in the order of the configuration. Reserved registers are 0, other
// addresses exception 02.
//
// At 0, the gateway:
//   0 layout version (2)
//   1, 2, 3 number of buses, devices, connected clients
//   4-5 seconds since the start
//   6-7 requests, 8-9 ADUs of other protocols (skipped), 10-11 connections closed because framing
//   was lost
//
// At 1000 + 64 * bus:
//   0 open (1) or not (0)
//   1 requests waiting
//   2-53 counters: transmissions, responses, exceptions, timeouts, bad CRCs, unsolicited frames,
//        stray bytes, noise bytes, echo mismatches, expired, refused because full, losses,
//        retries, broadcasts, late responses, early responses, foreign frames, shared reads,
//        always 0, reads answered from the cache, stops sent, stops unanswered, writes cancelled by
//        a stop, probes of offline devices, requests refused because their device was offline,
//        reads dropped from a full queue
//   54 quality of the answers: 0 not known, 1 good, 2 bad CRCs, of two devices or more; 55 with 2:
//        percent of the last answers with a bad CRC
//
// At 10000 + 32 * device:
//   0 its bus (1 is the first), 1 its address
//   2 state: 0 no request yet, 1 answering, 2 not answering, 3 offline, 4 its last answers had a
//        bad CRC, 5 its line is not open
//   3 unanswered transmissions in a row
//   4-17 counters: transmissions, responses, exceptions, timeouts, bad CRCs, late responses, early
//        responses
//   18 offline (1) or not (0)
//   19 milliseconds for which it is still held back after an unanswered request, 65535 if longer
//   20-21 bytes skipped before its answers that are no part of them (glitches, line drivers turning
//        on)
//   22 quality of its answers: 0 not known, 1 good, 2 bad CRCs, 3 bytes but never a valid frame
//        (baud rate, parity, A and B swapped?), 4 after the response timeout
//   23 with 2: percent of its last answers with a bad CRC
//   24 with 4: the smallest response_timeout to set, in milliseconds
#pragma once

#include <cstdint>
#include <vector>

#include "gateway/bus_set.hpp"
#include "modbus/pdu.hpp"

namespace mbgate::gateway {

/// What all clients together have sent.
struct ClientCounters {
  std::uint64_t requests = 0;
  std::uint64_t foreign_adus = 0;  ///< skipped: the protocol identifier was not 0
  std::uint64_t framing_lost = 0;
};

/// The state of the gateway at the moment of a request.
struct StatusView {
  const Settings& settings;
  const BusSet& all;
  std::size_t clients;
  ClientCounters counters;
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
