// SPDX-License-Identifier: Apache-2.0
#include "bus/settings.hpp"

#include <algorithm>

#include "bus/job.hpp"
#include "modbus/rtu.hpp"

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

Duration default_listen_first(const BusSettings& settings, std::span<const drive::Device> devices) {
  const auto whole = [](const drive::DeviceTiming& timing) {
    return timing.response_timeout + timing.response_wait + timing.quarantine_or_default();
  };
  Duration longest = whole(settings.timing);
  for (const drive::Device& device : devices) {
    longest = std::max(longest, whole(device.timing));
  }
  return longest;
}

Duration longest_stream(const BusSettings& settings) {
  constexpr int kTenths = 10;
  if (settings.line.framing == Framing::tcp) {
    return Duration{0};
  }
  const Duration frame =
      modbus::RtuTiming(settings.line.baud, settings.line.format)
          .duration_of(settings.line.framing == Framing::ascii ? kMaxFrameSize
                                                               : modbus::kMaxRtuSize);
  return frame + frame / kTenths;
}

Duration least_stop_deadline(const BusSettings& settings) {
  return settings.stop_wait + longest_stream(settings);
}

Duration stop_deadline(const BusSettings& settings) {
  return settings.stop_deadline.value_or(
      std::max<Duration>(std::chrono::seconds(2), least_stop_deadline(settings)));
}

}  // namespace mbgate::bus
