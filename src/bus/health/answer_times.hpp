// SPDX-License-Identifier: Apache-2.0
// How long the answers of a device have taken lately, and where the time went: a status display
// shows which drive is slow, and whether it is the drive, the wire or the queue.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

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

/// Of the answered transactions of a device.
struct AnswerTimes {
  Durations queue;   ///< from the acceptance of a request to its first transmission
  Durations wire;    ///< the frames of request and answer, with the pauses in them
  Durations device;  ///< from the end of the request to the first byte of the answer
};

}  // namespace mbgate::bus
