// SPDX-License-Identifier: Apache-2.0
// Durations, counted: histograms for metrics; how long the answers of a device have taken lately,
// and where the time went. A status display shows which drive is slow, and whether it is the drive,
// the wire or the queue.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>

#include "bus/instant.hpp"

namespace mbgate::bus {

// A histogram of durations: for each bound, the number of durations up to it since the counters
// were cleared. Collectors of metrics take differences.

class Histogram {
 public:
  static constexpr std::size_t kMostBounds = 17;

  /// The bounds ascend, are at most kMostBounds, and outlive the histogram.
  constexpr explicit Histogram(std::span<const Duration> bounds) : bounds_(bounds) {}

  void note(Duration duration) {
    const auto place = std::ranges::lower_bound(bounds_, duration) - bounds_.begin();
    ++counts_[static_cast<std::size_t>(place)];
    sum_ += duration;
  }
  /// What another one with the same bounds has counted counts here too.
  void add(const Histogram& other) {
    std::ranges::transform(counts_, other.counts_, counts_.begin(), std::plus());
    sum_ += other.sum_;
  }

  [[nodiscard]] std::span<const Duration> bounds() const { return bounds_; }
  /// One more than there are bounds: those up to each bound and beyond the one before, and then
  /// those beyond the last.
  [[nodiscard]] std::span<const std::uint64_t> counts() const {
    return std::span(counts_).first(bounds_.size() + 1);
  }
  [[nodiscard]] Duration sum() const { return sum_; }

 private:
  std::span<const Duration> bounds_;
  std::array<std::uint64_t, kMostBounds + 1> counts_{};
  Duration sum_{0};
};

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
