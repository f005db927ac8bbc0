// SPDX-License-Identifier: Apache-2.0
// The line discipline of RTU: one transaction at a time, silence before each transmission, a time
// limit for each response. It knows nothing of queues and retries; the bus above decides what is
// sent when. States as in Serial Line V1.02, figures 7 and 14.
#pragma once

#include <optional>
#include <string_view>

#include "bus/counters.hpp"
#include "bus/job.hpp"
#include "bus/response_framer.hpp"
#include "bus/settings.hpp"

namespace mbgate::bus {

class RtuLine {
 public:
  enum class State : std::uint8_t {
    initial,  ///< listening after the line was opened
    idle,
    emission,
    waiting_for_reply,
    waiting_turnaround_delay
  };
  /// How a transmission ended.
  enum class End : std::uint8_t {
    response,     ///< response() has it
    sent,         ///< a broadcast has left the wire; the turnaround delay runs
    no_response,  ///< the response timeout is over
    bad_crc       ///< a damaged answer
  };

  RtuLine(const BusSettings& settings, Duration listen_first, BusCounters& counters);

  /// The line was opened: listening begins, nothing of before counts any more.
  void open(Instant now);
  /// Is a transaction running? Only when none is may begin() be called.
  [[nodiscard]] bool is_busy() const { return transaction_ != nullptr; }
  /// From when on the silence before a transmission suffices; `gap` is asked for on top of it.
  [[nodiscard]] Instant ready_at(Duration gap) const;
  /// Starts to transmit now; `transaction` must outlive its end. Returns the frame.
  FrameBytes begin(const Transaction& transaction, const drive::DeviceTiming& timing, Instant now);
  /// Gives up the running transaction: nothing of it will be reported.
  void abort();

  void handle_bytes(modbus::Bytes bytes, Instant now);
  void handle_deadline(Instant now);
  [[nodiscard]] std::optional<Instant> next_deadline() const;
  /// The end of the running transaction, once; it is not busy any more then.
  std::optional<End> take_end();
  [[nodiscard]] const modbus::Pdu& response() const { return framer_.response(); }
  /// Did an echo differ since the last call?
  bool take_echo_mismatch();
  [[nodiscard]] State state(Instant now) const;

 private:
  modbus::Bytes compare_echo(modbus::Bytes bytes);
  void end(End how);
  void hold_until(Instant instant);

  modbus::RtuTiming timing_;
  Duration frame_gap_;
  Duration turnaround_;
  Duration settle_;
  Duration listen_first_;
  bool echo_;
  BusCounters& counters_;
  ResponseFramer framer_;

  Instant quiet_since_;  // the last byte in either direction
  Instant not_before_;   // listening, settling and turnaround delay end here
  Instant listening_until_;
  Instant turnaround_until_;
  const Transaction* transaction_ = nullptr;
  Instant emission_ends_;
  Instant response_deadline_;
  modbus::RtuBytes echo_expected_;
  std::size_t echo_seen_ = 0;
  bool echo_spoilt_ = false;    // what follows cannot be told from the rest of the echo
  bool echo_mismatch_ = false;  // to be reported
  std::optional<End> end_;
};

/// The state's name for status displays.
std::string_view to_text(RtuLine::State state);

}  // namespace mbgate::bus
