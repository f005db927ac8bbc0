// SPDX-License-Identifier: Apache-2.0
#include "bus/settings.hpp"

#include <algorithm>

#include "bus/job.hpp"
#include "modbus/frames.hpp"

namespace mbgate::bus {
namespace {

Duration longest_frame(const BusSettings& settings) {
  if (settings.line.framing == Framing::tcp) {
    return Duration{0};
  }
  return modbus::RtuTiming(settings.line.baud, settings.line.format)
      .duration_of(settings.line.framing == Framing::ascii ? kMaxFrameSize : modbus::kMaxRtuSize);
}

}  // namespace

Duration longest_transaction(const BusSettings& settings, std::span<const drive::Device> devices) {
  constexpr std::size_t kShortFrame = 8;  // 03, or the echo of 16, in RTU
  Duration waiting = devices.empty()
                         ? settings.timing.response_timeout + settings.timing.response_wait
                         : Duration{0};
  for (const drive::Device& device : devices) {
    waiting = std::max(waiting, device.timing.response_timeout + device.timing.response_wait);
  }
  if (settings.line.framing == Framing::tcp) {
    return waiting;
  }
  const std::size_t characters = settings.line.framing == Framing::ascii
                                     ? kMaxFrameSize + 2 * kShortFrame
                                     : modbus::kMaxRtuSize + kShortFrame;
  return modbus::RtuTiming(settings.line.baud, settings.line.format).duration_of(characters) +
         waiting + settings.settle;
}

Duration longest_stop_wait(const BusSettings& settings, std::vector<drive::Device> devices) {
  for (drive::Device& device : devices) {
    for (const auto& slow : device.profile.slow) {
      device.timing.response_timeout =
          std::max(device.timing.response_timeout, slow.response_timeout);
    }
  }
  const Duration transaction = longest_transaction(settings, devices);
  if (settings.line.framing == Framing::tcp) {
    return transaction;
  }
  const Duration silence = settings.frame_gap.value_or(
      modbus::RtuTiming(settings.line.baud, settings.line.format).t3_5());
  return silence + std::max(transaction - settings.settle + settings.frame_slack_or_default(),
                            longest_frame(settings) + settings.turnaround);
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
  const Duration frame = longest_frame(settings);
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
