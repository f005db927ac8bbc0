// SPDX-License-Identifier: Apache-2.0
// Whether a line has an echo though the settings say that it has none: own requests are heard.
#pragma once

#include <utility>

#include "bus/instant.hpp"

namespace mbgate::bus {

class DeniedEcho {
 public:
  /// The line was opened: it may be another adapter.
  void open() {
    is_heard_ = false;
    in_row_ = 0;
    reported_ = false;
  }
  /// What was just sent was heard. True: that proves an echo, and was not told yet.
  bool note_heard(Instant now) {
    if (std::exchange(is_heard_, true)) {
      return false;
    }
    const bool is_soon = in_row_ > 0 && now <= last_ + kWithin;
    last_ = now;
    if (!is_found()) {
      in_row_ = is_soon ? in_row_ + 1 : 1;
    }
    return is_found() && !std::exchange(reported_, true);
  }
  /// A transmission has ended. A read that was answered without its echo shows that there is none.
  void note_ended(bool is_answered_read) {
    if (!std::exchange(is_heard_, false) && is_answered_read) {
      in_row_ = 0;
    }
  }
  [[nodiscard]] bool is_found() const { return in_row_ == kEchoesToTell; }

 private:
  // Another client may have asked for the same a moment before, and an adapter kept that; hardly
  // for two requests in a row, so soon after each other.
  static constexpr unsigned kEchoesToTell = 2;
  static constexpr Duration kWithin = std::chrono::minutes(1);

  bool is_heard_ = false;  // since the last transmission ended
  unsigned in_row_ = 0;
  Instant last_ = Instant::min();
  bool reported_ = false;
};

}  // namespace mbgate::bus
