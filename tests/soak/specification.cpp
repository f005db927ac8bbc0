// SPDX-License-Identifier: Apache-2.0
#include "soak/specification.hpp"

#include <algorithm>

namespace mbgate::soak::spec {

using namespace std::chrono_literals;

bool is_same_line(const bus::LineSettings& a, const bus::LineSettings& b) {
  return a.baud == b.baud && a.framing == b.framing && a.format == b.format && a.remote == b.remote;
}

Duration silence_of(const bus::BusSettings& bus) {
  return bus.frame_gap ? *bus.frame_gap : WireTimes(bus.line).silence();
}

// At least `stop_wait` and 1.1 times the longest frame.
Duration stop_deadline_of(const bus::BusSettings& bus) {
  if (bus.stop_deadline) {
    return *bus.stop_deadline;
  }
  const bool ascii = bus.line.framing == bus::Framing::ascii;
  const Duration longest = WireTimes(bus.line).of(ascii ? kAsciiFrame : kRtuFrame);
  return std::max<Duration>(2s, bus.stop_wait + longest + longest / 10);
}

Duration quarantine_of(const drive::DeviceTiming& timing) {
  return timing.quarantine ? *timing.quarantine : timing.response_timeout;
}

Duration probe_timeout_of(const drive::DeviceTiming& timing) {
  return timing.probe_timeout ? *timing.probe_timeout
                              : std::min<Duration>(timing.response_timeout, 100ms);
}

}  // namespace mbgate::soak::spec
