// SPDX-License-Identifier: Apache-2.0
// Follows one line for a trace: assigns the bytes that were heard to transmissions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "bus/bus_action.hpp"
#include "gateway/trace/trace_record.hpp"
#include "modbus/bytes.hpp"

namespace mbgate::gateway {

class LineTrace {
 public:
  /// What is kept of a transmission: twice what the longest answer has, in ASCII.
  static constexpr std::size_t kMostHeard = 1024;

  /// What has come to its end. Without requests: bytes that nobody had asked for.
  struct Told {
    bus::TransmissionTitle title;
    WireTrace wire;
  };

  /// So many transmissions are on the wire that are not traced: what is heard is theirs.
  void begin_amid(std::size_t in_flight) { from_before_ = in_flight; }
  /// What comes now is no part of what came before. `blank` has what is known of the line alone.
  void opened(const WireTrace& blank, Instant now);
  /// `wire` has what is known before anything was sent.
  void began(const bus::TransmissionBegan& began, WireTrace wire);
  /// The frame of the transmission that began last.
  void transmitted(modbus::Bytes frame);
  /// To be called before the bus gets the bytes.
  void heard(modbus::Bytes bytes, const WireTrace& blank, Instant now);
  void over(const bus::TransmissionOver& over, Instant now);
  /// The request is answered: what is still on the wire for it was cut.
  void answered(std::uint32_t request, Instant now);
  /// Bytes that nobody had asked for come to their end with a pause, or after a while.
  void rest(Instant now);

  std::vector<Told> take() { return std::exchange(reported_, {}); }

 private:
  struct Flight {
    bus::TransmissionTitle title;
    WireTrace wire;
  };

  void hear_adus(modbus::Bytes bytes, const WireTrace& blank, Instant now);
  /// An ADU, or the beginning of one.
  void hear_adu(modbus::Bytes adu, const WireTrace& blank, Instant now);
  void hear_unasked(modbus::Bytes bytes, const WireTrace& blank, Instant now);
  void end_unasked();
  void end_cut(Flight cut, Instant now);

  std::vector<Flight> in_flight_;
  std::optional<WireTrace> unasked_;
  ByteString partial_;  // of a connection: the beginning of an ADU
  std::size_t from_before_ = 0;
  ByteString echo_;  // of a broadcast: it may be heard when the transaction is over
  std::vector<Told> reported_;
};

}  // namespace mbgate::gateway
