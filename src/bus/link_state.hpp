// SPDX-License-Identifier: Apache-2.0
// Whether the line of a bus is open, and when it is opened again.
//
// A line that could not be opened, or was lost, is opened again after a delay. The delay doubles up
// to a limit. A connection that its server has closed in good order *rests*: servers close idle
// connections, and some close after each answer. It is opened again without delay as soon as there
// is a request for it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "bus/instant.hpp"
#include "bus/settings.hpp"

namespace mbgate::bus {

/// How a line was lost.
enum class Loss : std::uint8_t {
  failed,  ///< it could not be opened, or it died
  closed   ///< the far end of a connection has closed it
};

class LinkState {
 public:
  explicit LinkState(Duration reopen_min) : delay_(reopen_min) {}

  [[nodiscard]] bool is_open() const { return state_ == State::open; }
  /// It is not open, and nobody knows when it will be: no job may wait for it.
  [[nodiscard]] bool is_closed() const { return state_ == State::closed; }
  /// It is opened when there is a request for it, and not before.
  [[nodiscard]] bool is_resting() const { return state_ == State::resting; }
  /// It works as far as is known: it is open, or rests, or is being opened after resting.
  [[nodiscard]] bool serves() const { return is_open() || is_resting() || state_ == State::waking; }
  /// The first attempt to open it runs.
  [[nodiscard]] bool is_starting() const { return state_ == State::starting; }
  /// After restart(), until that attempt has succeeded or failed.
  [[nodiscard]] bool is_reopening() const { return state_ == State::reopening; }

  /// When it was opened last.
  [[nodiscard]] Instant opened_at() const { return opened_at_; }

  /// It is open, but not yet for `reopen_max`: too short to say that it works.
  [[nodiscard]] bool is_new(const BusSettings& settings, Instant now) const {
    return now - opened_at_ < settings.reopen_max;
  }

  void note_opened(Instant now) {
    state_ = State::open;
    opened_at_ = now;
    reopen_at_.reset();
  }
  /// Schedules the next attempt.
  void note_lost(const BusSettings& settings, Instant now) {
    if (is_open() && !is_new(settings, now)) {
      // A line that dies as soon as it is open gets no such favour.
      delay_ = settings.reopen_min;
    }
    left_at_ = is_open() ? now : left_at_;
    state_ = State::closed;
    reopen_at_ = now + delay_;
    delay_ = std::min(2 * delay_, settings.reopen_max);
  }
  /// The server has closed the connection. `answered`: after an answer, so the delay starts from
  /// `reopen_min` again.
  void rest(const BusSettings& settings, bool answered, Instant now) {
    left_at_ = now;
    state_ = State::resting;
    delay_ = answered ? settings.reopen_min : delay_;
  }
  /// An adapter hangs: it is being closed and opened again.
  void restart(Instant now) {
    state_ = State::reopening;
    tried_at_ = now;
  }
  /// After rest(): an attempt to open it runs.
  void wake(Instant now) {
    state_ = State::waking;
    tried_at_ = now;
  }
  /// A stop waits: the next attempt is due now, but no sooner than `reopen_min` after the last one.
  void hurry(const BusSettings& settings, Instant now) {
    if (reopen_at_) {
      reopen_at_ = std::min(*reopen_at_, std::max(now, tried_at_ + settings.reopen_min));
    }
  }
  /// No attempt to open it is scheduled any more.
  void stop() { reopen_at_.reset(); }
  /// Is an attempt due? True once for each attempt.
  bool take_due(Instant now) {
    if (!reopen_at_ || now < *reopen_at_) {
      return false;
    }
    reopen_at_.reset();
    tried_at_ = now;
    return true;
  }
  [[nodiscard]] std::optional<Instant> next_attempt() const { return reopen_at_; }
  /// Since when it has not been open, if it is not.
  [[nodiscard]] Instant left_at() const { return left_at_; }

 private:
  enum class State : std::uint8_t {
    starting,  ///< the first attempt to open it runs
    closed,    ///< the next attempt is scheduled or runs
    open,
    reopening,  ///< it hung, and an attempt to open it runs
    resting,
    waking  ///< it rested, and an attempt to open it runs
  };

  State state_ = State::starting;
  Instant opened_at_;
  std::optional<Instant> reopen_at_;
  Instant tried_at_ = Instant::min();
  Instant left_at_ = Instant::min();
  Duration delay_;
};

// Detects a hung serial adapter: it accepts what is transmitted, but nothing at all is received. A
// hung USB adapter stays like that until it is closed and opened again. It looks the same when all
// devices are switched off, so the adapter is reopened less and less often.

class AdapterWatch {
 public:
  /// The line was opened: the silence is measured from now on. Virtual lines do not hang and are
  /// not watched.
  void open(LineKind kind, Instant now) {
    kind_ = kind;
    silent_since_ = now;
    requests_ = 0;
  }
  /// A byte was received, of an echo or of anything else.
  void note_byte(Instant now) {
    silent_since_ = now;
    requests_ = 0;
    reopenings_ = 0;
  }
  /// A request that expects an answer was sent.
  void note_request() { ++requests_; }

  /// Was nothing received for `hung_after` (doubled at each reopening, up to `hung_max`), while at
  /// least `hung_requests` requests were sent?
  [[nodiscard]] bool is_hung(const BusSettings& settings, Instant now) const {
    const bool is_watched = kind_ != LineKind::virtual_line ||
                            (settings.line.remote && settings.line.framing != Framing::tcp);
    return is_watched && settings.hung_after > Duration::zero() &&
           requests_ >= settings.hung_requests && silence(now) >= patience(settings);
  }
  /// The adapter is being reopened because it is hung. Returns true for the first reopening since
  /// something was received.
  bool note_reopening() { return reopenings_++ == 0; }

  [[nodiscard]] Duration silence(Instant now) const { return now - silent_since_; }
  [[nodiscard]] unsigned requests() const { return requests_; }

 private:
  [[nodiscard]] Duration patience(const BusSettings& settings) const {
    Duration patience = settings.hung_after;
    for (unsigned i = 0; i < reopenings_ && patience < settings.hung_max; ++i) {
      patience *= 2;
    }
    return std::max(settings.hung_after, std::min(patience, settings.hung_max));
  }

  LineKind kind_ = LineKind::virtual_line;
  Instant silent_since_;
  unsigned requests_ = 0;    ///< sent since then
  unsigned reopenings_ = 0;  ///< without success so far
};

}  // namespace mbgate::bus
