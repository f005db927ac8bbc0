// SPDX-License-Identifier: Apache-2.0
// The times that a bus waits for, each with a name.
#pragma once

#include <algorithm>
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
  Timers() { clear(); }

  void set(Timer timer, std::optional<Wake> wake) {
    Wake& known = all_.at(static_cast<std::size_t>(timer));
    known = wake && is_before(*wake, known) ? *wake : known;
  }
  void set(Timer timer, std::optional<Instant> at) {
    if (at) {
      set(timer, std::optional(Wake{*at}));
    }
  }
  void clear() { all_.fill(kNever); }
  /// The first of them.
  [[nodiscard]] std::optional<Wake> first() const {
    const Wake& first = *std::ranges::min_element(all_, is_before);
    return first.at == kNever.at ? std::nullopt : std::optional(first);
  }

 private:
  static constexpr Wake kNever{Instant::max()};
  std::array<Wake, kTimers> all_;
};

}  // namespace mbgate::bus
