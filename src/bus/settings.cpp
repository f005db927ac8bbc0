// SPDX-License-Identifier: Apache-2.0
#include "bus/settings.hpp"

#include <algorithm>

namespace mbgate::bus {

Duration longest_response_timeout(const BusSettings& settings,
                                  std::span<const drive::Device> devices) {
  const auto whole = [](const drive::DeviceTiming& timing) {
    return timing.response_timeout + timing.response_wait;
  };
  Duration longest = whole(settings.timing);
  for (const drive::Device& device : devices) {
    longest = std::max(longest, whole(device.timing));
    for (const drive::SlowRegisters& slow : device.profile.slow) {
      longest = std::max(longest, slow.response_timeout + device.timing.response_wait);
    }
  }
  return longest;
}

}  // namespace mbgate::bus
