// SPDX-License-Identifier: Apache-2.0
// The use of a connection to a Modbus TCP server: whether a request was sent on it and answered,
// whether its server closes it after each answer, and whether it must be replaced because the
// server no longer sends anything.
#pragma once

#include <optional>

#include "bus/instant.hpp"

namespace mbgate::bus {

/// A connection that is to be replaced was asked for so long, and nothing has come meanwhile.
inline constexpr Duration kSilenceToReplace = std::chrono::seconds(30);
/// A server that closes after each answer does so in this time. What was sent to it meanwhile
/// would be lost.
inline constexpr Duration kTimeToClose = std::chrono::milliseconds(50);

class ConnectionUse {
 public:
  /// A new connection. What was seen of the server's habits is kept.
  void open() {
    was_asked_ = false;
    answered_at_.reset();
    closes_by_ = Instant::min();
  }
  void forget_unanswered() {
    unheard_since_.reset();
    unanswered_ = 0;
  }
  void note_asked(Instant now) {
    was_asked_ = true;
    unheard_since_ = unheard_since_.value_or(now);
  }
  /// A request that was sent at `sent` has timed out. One that was sent before the last byte came
  /// says nothing of the time since.
  void note_unanswered(Instant sent) {
    unanswered_ += unheard_since_ && sent >= *unheard_since_ ? 1U : 0U;
  }
  /// An answer, in time or late. A server that leaves the connection open after its first answer is
  /// as others are.
  void note_answer(Instant now) {
    closes_after_answer_ = closes_after_answer_ && !answered_at_;
    closes_by_ = closes_after_answer_ ? now + kTimeToClose : Instant::min();
    answered_at_ = now;
  }
  /// The server has closed the connection.
  void note_closed(Instant now) {
    closes_after_answer_ = answered_at_ && now - *answered_at_ <= kTimeToClose;
  }

  [[nodiscard]] bool was_asked() const { return was_asked_; }
  [[nodiscard]] bool has_answered() const { return answered_at_.has_value(); }
  /// Until then the server may close the connection, because it did so before.
  [[nodiscard]] Instant closes_by() const { return closes_by_; }
  /// When the connection is to be replaced if nothing comes: `replace_after` requests are
  /// unanswered. Never, if that is 0.
  [[nodiscard]] std::optional<Instant> replace_at(unsigned replace_after) const {
    const bool enough = replace_after > 0 && unanswered_ >= replace_after;
    return enough ? std::optional(*unheard_since_ + kSilenceToReplace) : std::nullopt;
  }

 private:
  bool was_asked_ = false;
  std::optional<Instant> answered_at_;  // the last answer on this connection
  bool closes_after_answer_ = false;    // the connection before was closed right after an answer
  Instant closes_by_ = Instant::min();
  std::optional<Instant> unheard_since_;  // the first request since the last byte that came
  unsigned unanswered_ = 0;               // of these requests, those that timed out
};

}  // namespace mbgate::bus
