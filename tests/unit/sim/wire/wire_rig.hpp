// SPDX-License-Identifier: Apache-2.0
// A wire of 10000 baud 8N1, so that a character takes 1 ms and t3.5 is 3.5 ms, driven in virtual
// time.
#pragma once

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "sim/wire/wire.hpp"
#include "support/hex.hpp"

namespace mbgate::test {

using namespace std::chrono_literals;
using bus::Duration;
using bus::Instant;
using sim::ModelKind;

/// Read status code, request and answer as MOONS' manual prints them (5.1).
inline constexpr auto kReadStatus = "01 03 00 01 00 01 D5 CA";
inline constexpr auto kStatus = "01 03 02 00 09 78 42";
/// The same for address 2.
inline constexpr auto kReadStatus2 = "02 03 00 01 00 01 D5 F9";
inline constexpr auto kStatus2 = "02 03 02 00 09 3C 42";

inline sim::WireSettings slow_line() {
  return {.baud = modbus::Baud{10000}, .chunk = 0ms, .frames_kept = 10};
}

/// What the adapter hands over, and when.
using Deliveries = std::vector<std::pair<Duration, std::string>>;

class WireRig {
 public:
  WireRig(const sim::WireSettings& settings, const std::vector<sim::DeviceSettings>& devices)
      : wire_(settings, devices) {}

  void transmit(std::string_view frame, Duration at) { wire_.transmit(unhex(frame), Instant(at)); }
  /// Jumps from event to event as long as there are any.
  Deliveries run() {
    Deliveries deliveries;
    while (const auto at = wire_.next_event()) {
      const auto bytes = wire_.advance(*at);
      if (!bytes.empty()) {
        deliveries.emplace_back(at->time_since_epoch(), hex(bytes));
      }
    }
    return deliveries;
  }
  /// All bytes that run() delivers.
  std::string received() {
    std::string all;
    for (const auto& [at, text] : run()) {
      all += (all.empty() ? "" : " ") + text;
    }
    return all;
  }
  [[nodiscard]] sim::Wire& wire() { return wire_; }
  [[nodiscard]] const sim::WireCounters& counters() const { return wire_.counters(); }

 private:
  sim::Wire wire_;
};

}  // namespace mbgate::test
