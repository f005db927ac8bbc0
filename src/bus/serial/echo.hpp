// SPDX-License-Identifier: Apache-2.0
// Whether a line has an echo (the transceiver receives what it sends), and the removal of that echo
// from what is received.
//
// Where there is an echo, it is compared with what was sent and removed. If the settings do not say
// whether there is one, this is learned: a received frame that is identical to the request and
// cannot be its answer, with the answer behind it, is an echo. Alone it proves nothing: a device
// may have answered so. Until this is known, bytes that may be the beginning of an echo are held
// back, and a frame that could be an echo acknowledges nothing from a device that was not heard
// since the line was opened.
//
// An echo that did not come in time may still come late. If the answer to the request looks the
// same, the late echo could be mistaken for the answer to the same request sent once more.
// Therefore, for each echo that may still come, one more frame that repeats such a request is
// refused. Echoes come in the order of the requests: once the echo of a later request has come, no
// earlier one will.
#pragma once

#include <bitset>
#include <boost/container/static_vector.hpp>
#include <optional>
#include <utility>

#include "bus/counters.hpp"
#include "bus/job.hpp"
#include "bus/line_end.hpp"

namespace mbgate::bus {

/// The most echoes that may still come late. Each was waited for as long as an answer.
inline constexpr std::size_t kMostOwedEchoes = 4;

class Echo {
 public:
  /// `setting` says whether there is an echo; none: it is learned from the line. What is noticed is
  /// added to `counters` and `faults`.
  Echo(std::optional<bool> setting, BusCounters& counters, LineFaults& faults);

  /// The line was opened. An echo that was found is still there, until reads lack it; without one,
  /// it may be another adapter.
  void open();
  /// `frame` is sent for `transaction` now. Its response timeout ends at `due`.
  void expect(const Transaction& transaction, const FrameBytes& frame, Instant now, Instant due);

  /// Bytes that came at one instant, from `begin` on.
  struct Piece {
    std::size_t begin;
    Instant came;
  };
  static constexpr std::size_t kMostPieces = 16;
  using Pieces = boost::container::static_vector<Piece, kMostPieces>;
  /// Bytes that were held back and are not an echo, and when they came. Of more pieces than there
  /// is room for, the last ones count as one.
  struct Held {
    FrameBytes bytes;
    Pieces pieces;
  };
  struct Heard {
    Held held;
    modbus::Bytes bytes;  ///< and then those of the new bytes that are not an echo
  };
  /// Returns what is not an echo and cannot become one.
  [[nodiscard]] Heard take(modbus::Bytes bytes, Instant now);
  /// Stops waiting for the rest of a possible echo. Returns the bytes that were held back.
  [[nodiscard]] Held release();

  /// The echo differed from what was sent: until the wait for the answer ends, the bytes that
  /// follow cannot be told from its rest.
  [[nodiscard]] bool is_spoilt() const { return spoilt_; }
  /// Does this, as a response, look like the echo of what was sent?
  [[nodiscard]] bool is_repetition(const modbus::Pdu& response) const;
  /// Is this frame, which no request waits for, the echo of the last read rather than data that
  /// look the same?
  [[nodiscard]] bool is_of_read(std::uint8_t address, const modbus::Pdu& frame) const;
  /// May this response be the late echo of an identical request instead?
  [[nodiscard]] bool is_owed(const modbus::Pdu& response) const;
  /// If so, that echo is no longer expected. Returns whether it was.
  bool take_owed(const modbus::Pdu& response);
  /// Was an echo seen? Then such a response is taken for the late echo, unless something else says
  /// otherwise.
  [[nodiscard]] bool was_shown() const { return shown_; }
  [[nodiscard]] bool is_learned() const { return learns_; }
  [[nodiscard]] bool is_unknown() const { return state_ == State::unknown; }
  /// What the settings do not say.
  [[nodiscard]] NoticedEcho noticed() const {
    if (state_ == State::present) {
      return learns_ ? NoticedEcho::found : NoticedEcho::none;
    }
    return is_unknown() && unproven_reported_ ? NoticedEcho::unproven : NoticedEcho::none;
  }
  /// A response that repeats the request is taken for the echo. True: there was another one before
  /// it. `proves`: it cannot be anything else, if an answer follows.
  bool pass(bool proves = false) {
    echoed_ = echoed_ || proves;
    return std::exchange(passed_, true);
  }
  /// An echo was seen: the line has one.
  void find();
  /// A response that repeats the request was accepted as the answer, because nothing showed that
  /// the line has an echo.
  void note_unproven();
  /// A response was accepted. `came_first`: nothing at all came before it; an echo would have. (If
  /// anything did come, it may be a damaged echo.) On a line with an echo, one may be lost, but not
  /// those of several reads in a row. Returns whether this has shown that the line has none.
  bool note_answered(const modbus::Pdu& response, bool came_first);
  /// Has the device that was asked last answered something that is no echo, since the line was
  /// opened?
  [[nodiscard]] bool has_heard_device() const { return heard_.test(address_); }

 private:
  [[nodiscard]] bool is_awaited() const { return seen_ < expected_.size(); }
  /// No echo of what was sent is expected any more.
  void forget();
  [[nodiscard]] std::optional<std::size_t> matching(modbus::Bytes bytes) const;
  void owe(Instant now);
  Heard compare(modbus::Bytes bytes);
  Heard look_for(modbus::Bytes bytes, Instant now);

  enum class State : std::uint8_t { absent, present, unknown };
  State state_;
  bool learns_;  // the settings do not say whether there is an echo
  BusCounters& counters_;
  LineFaults& faults_;
  std::uint8_t address_ = 0;
  std::optional<modbus::Pdu> asked_;  // its echo may come after the answer was given up
  bool may_answer_ = false;           // the answer to what was sent last looks the same as its echo
  FrameBytes expected_;
  std::size_t seen_ = 0;
  /// Echoes that did not come, of requests whose answers look the same, in the order of the
  /// requests. The oldest is dropped for the newest.
  boost::container::static_vector<FrameBytes, kMostOwedEchoes> owed_;
  Instant due_;          // when what was sent last should have been answered
  Pieces held_;          // of what may be an echo, and is not passed on yet: how it came
  bool echoed_ = false;  // all of it came, and could not be the answer: an echo if one follows
  std::bitset<256> heard_;
  bool spoilt_ = false;
  bool passed_ = false;  // a repetition of the request was taken for the echo
  bool shown_ = false;
  unsigned lost_ = 0;  // since one was shown: reads that were answered without one
  bool unproven_reported_ = false;
};

}  // namespace mbgate::bus
