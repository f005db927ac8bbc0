// SPDX-License-Identifier: Apache-2.0
// How a device is, and since when, as those who ask are told. Counters may be cleared; this stays.
#pragma once

#include <cstdint>
#include <utility>

#include "bus/instant.hpp"

namespace mbgate::bus {

/// The numbers are those of the registers of unit 255.
enum class DeviceState : std::uint8_t {
  not_asked = 0,      ///< nothing was sent to it
  answering = 1,      ///< it has answered the last request, perhaps late
  not_answering = 2,  ///< it has not
  offline = 3,        ///< it has not answered for so long that it is only probed
  damaged = 4         ///< its last answers had a bad CRC or LRC
};

/// The state that lasts, and when it began.
class LastingState {
 public:
  [[nodiscard]] DeviceState state() const { return state_; }
  /// Instant::min() as long as nothing is known of the device.
  [[nodiscard]] Instant since() const { return since_; }
  /// It is in this state at `at`. Returns the one that it was in.
  DeviceState enter(DeviceState state, Instant at) {
    if (state != state_) {
      since_ = at;
    }
    return std::exchange(state_, state);
  }

 private:
  DeviceState state_ = DeviceState::not_asked;
  Instant since_ = Instant::min();
};

}  // namespace mbgate::bus
