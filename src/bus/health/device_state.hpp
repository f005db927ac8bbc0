// SPDX-License-Identifier: Apache-2.0
// How a device is, as those who ask are told. Counters may be cleared; this stays.
#pragma once

#include <cstdint>

namespace mbgate::bus {

/// The numbers are those of the registers of unit 255.
enum class DeviceState : std::uint8_t {
  not_asked = 0,      ///< nothing was sent to it
  answering = 1,      ///< it has answered the last request, perhaps late
  not_answering = 2,  ///< it has not
  offline = 3,        ///< it has not answered for so long that it is only probed
  damaged = 4         ///< all its answers had a bad CRC or LRC
};

}  // namespace mbgate::bus
