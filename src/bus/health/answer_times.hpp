// SPDX-License-Identifier: Apache-2.0
// How long the answers of a device have taken lately, and where the time went: a status display
// shows which drive is slow, and whether it is the drive, the wire or the queue.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "bus/histogram.hpp"
#include "bus/instant.hpp"

namespace mbgate::bus {

/// Durations, counted in steps of a fifth to a quarter from 64 us to 30 s. The last one or two
/// thousand count. Takes no memory but its own.
class Durations {
 public:
  void note(Duration duration);
  /// The step that holds the duration which `percent` of all do not exceed: its upper end. Nothing
  /// if there are none.
  [[nodiscard]] std::optional<Duration> percentile(unsigned percent) const;

 private:
  static constexpr std::size_t kSteps = 80;

  std::array<std::uint16_t, kSteps> counts_{};
  unsigned all_ = 0;
};

/// From the fastest drives to the longest timeouts.
extern const std::array<Duration, 14> kLatencyBounds;

/// Durations of late, and all of them in steps that metrics show.
class Latency {
 public:
  void note(Duration duration) {
    lately_.note(duration);
    all_.note(duration);
  }
  /// All of the other's count here too, but not lately.
  void add_all(const Latency& other) { all_.add(other.all_); }
  [[nodiscard]] const Durations& lately() const { return lately_; }
  [[nodiscard]] const Histogram& all() const { return all_; }

 private:
  Durations lately_;
  Histogram all_{kLatencyBounds};
};

/// Of the answered transactions of a device.
struct AnswerTimes {
  Latency queue;   ///< from the acceptance of a request to its first transmission
  Latency wire;    ///< the frames of request and answer, with the pauses in them
  Latency device;  ///< from the end of the request to the first byte of the answer
};

}  // namespace mbgate::bus
