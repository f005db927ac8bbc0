// SPDX-License-Identifier: Apache-2.0
// The times that a bus waits for, each with a name.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "bus/instant.hpp"

namespace mbgate::bus {

enum class Timer : std::uint8_t {
  opening,           ///< a closed line is opened again
  queue_deadline,    ///< the first deadline of what waits in the queue
  running_deadline,  ///< the same of what is between two tries or two transactions
  line,              ///< what the line discipline waits for: an answer, the end of a frame
  transmission,      ///< something may be sent, as far as is known
  resting_stop,      ///< a stop that its device refused is sent again
  given_up_stop,     ///< a stop to a device that was given up has its turn
  waiting_stop       ///< a stop has waited long enough for the line to be opened
};
inline constexpr std::size_t kTimers = 8;

class Timers {
 public:
  void set(Timer timer, std::optional<Wake> wake) {
    std::optional<Wake>& known = all_.at(static_cast<std::size_t>(timer));
    known = earlier(known, wake);
    first_ = earlier(first_, wake);
  }
  void set(Timer timer, std::optional<Instant> at) {
    if (at) {
      set(timer, std::optional(Wake{*at}));
    }
  }
  void clear() { *this = {}; }
  [[nodiscard]] std::optional<Wake> operator[](Timer timer) const {
    return all_.at(static_cast<std::size_t>(timer));
  }
  /// The first of them. Of two at the same instant the one that must not come early.
  [[nodiscard]] const std::optional<Wake>& first() const { return first_; }

 private:
  std::array<std::optional<Wake>, kTimers> all_{};
  std::optional<Wake> first_;
};

}  // namespace mbgate::bus
