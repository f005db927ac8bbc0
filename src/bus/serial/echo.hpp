// SPDX-License-Identifier: Apache-2.0
// Whether a line hears itself, and the echo of what was sent in what comes back.
//
// Where there is an echo, it is compared with what was sent and taken out. Where nobody has said
// whether there is one, the line shows it: a frame identical to a request whose echo cannot be its
// answer is one. Until then what looks like its beginning is held back.
//
// An echo that did not come while its request was waited for may still come, and where the answer
// looks like it, be taken for that of the same request sent once more. So of those that repeat such
// a request one more is refused for each echo that is owed. Echoes come in the order in which the
// requests left: once that of a later one has come, none of before does.
#pragma once

#include <boost/container/static_vector.hpp>
#include <optional>
#include <utility>

#include "bus/counters.hpp"
#include "bus/job.hpp"
#include "bus/line_end.hpp"
#include "bus/state_reader.hpp"

namespace mbgate::bus {

/// Each was waited for as long as an answer.
inline constexpr std::size_t kMostOwedEchoes = 4;

class Echo {
 public:
  /// `setting` says whether there is one; none: the line shows it. What is noticed is added to
  /// `counters` and `faults`.
  Echo(std::optional<bool> setting, BusCounters& counters, LineFaults& faults);

  /// The line was opened: it may be another adapter.
  void open();
  /// `frame` is sent for `transaction` now, and answered until `due`.
  void expect(const Transaction& transaction, const FrameBytes& frame, Instant now, Instant due);
  /// No echo of what was sent matters any more.
  void forget();

  /// Bytes that were held back, and are no echo.
  struct Held {
    FrameBytes bytes;
    Instant since;  ///< when the first of them came
  };
  struct Heard {
    Held held;
    modbus::Bytes bytes;  ///< and behind them what is no echo of those that came now
  };
  /// What of these bytes is no echo, nor may become one.
  [[nodiscard]] Heard take(modbus::Bytes bytes, Instant now);
  /// The rest of an echo that may have begun is waited for no longer.
  [[nodiscard]] Held release();

  /// The echo differed from what was sent: what follows cannot be told from its rest.
  [[nodiscard]] bool is_spoilt() const { return spoilt_; }
  /// Does this, as a response, look like the echo of what was sent?
  [[nodiscard]] bool is_repetition(const modbus::Pdu& response) const;
  /// Nobody waits for this frame: is it the echo of the last read rather than data that look so?
  [[nodiscard]] bool is_of_read(std::uint8_t address, const modbus::Pdu& frame) const;
  /// May this, as a response, be an echo because one of an identical request is owed?
  [[nodiscard]] bool is_owed(const modbus::Pdu& response) const;
  /// If so, it is owed no more.
  bool take_owed(const modbus::Pdu& response);
  /// Such a response is that echo if nothing else says otherwise: since the line was opened, an
  /// echo was shown.
  [[nodiscard]] bool was_shown() const { return shown_; }
  [[nodiscard]] bool is_learned() const { return learns_; }
  [[nodiscard]] bool is_unknown() const { return state_ == State::unknown; }
  [[nodiscard]] bool is_present() const { return state_ == State::present; }
  /// Such a response is taken for the echo. True: another one was before it.
  bool pass() { return std::exchange(passed_, true); }
  /// There is one: it was seen.
  void find();
  /// Such a response was taken for the answer, because nothing was seen that speaks against it.
  void note_unproven();
  /// A response was taken, and nothing at all came before it: an echo would have. What did come may
  /// be a damaged one; and where one was heard, it was lost this time, but not many times in a row.
  void note_answered();

 private:
  friend struct mbgate::StateReader;
  [[nodiscard]] bool is_awaited() const { return seen_ < expected_.size(); }
  [[nodiscard]] bool shows_anything() const;
  [[nodiscard]] std::optional<std::size_t> matching(modbus::Bytes bytes) const;
  void owe(Instant now);
  Heard compare(modbus::Bytes bytes);
  Heard look_for(modbus::Bytes bytes, Instant now);

  enum class State : std::uint8_t { absent, present, unknown };
  State state_;
  bool learns_;  // nobody said whether there is one
  BusCounters& counters_;
  LineFaults& faults_;
  std::uint8_t address_ = 0;
  std::optional<modbus::Pdu> asked_;  // its echo may come when nobody waits for an answer any more
  bool may_answer_ = false;           // what was sent last looks like the answer to it
  FrameBytes expected_;
  std::size_t seen_ = 0;
  /// Those that did not come, of requests whose answers look like them, in the order of these. The
  /// oldest gives way to the newest.
  boost::container::static_vector<FrameBytes, kMostOwedEchoes> owed_;
  Instant due_;         // when what was sent last should have been answered
  Instant held_since_;  // the first byte of what may be an echo, and is not given on yet
  bool spoilt_ = false;
  bool passed_ = false;  // a repetition came that was taken for the echo
  bool shown_ = false;   // since the line was opened
  unsigned lost_ = 0;    // since one was shown: reads that were answered without one
  bool unproven_told_ = false;
};

}  // namespace mbgate::bus
