// SPDX-License-Identifier: Apache-2.0
// What the script of `confusable` decides: the times of a bus, and up to six requests whose answers
// look like one another.
#pragma once

#include <array>
#include <deque>
#include <vector>

#include "bus/bus.hpp"
#include "fuzz/fuzz.hpp"

namespace mbgate::fuzz::confusable {

using bus::Duration;
using bus::Instant;
using Pdu = std::vector<std::uint8_t>;

/// How late a driver may be; the script's bytes say so from its end on.
class Lateness {
 public:
  Lateness(const std::uint8_t* data, std::size_t size) : left_(data, size) {}
  Duration next() {
    if (left_.empty()) {
      return Duration{0};
    }
    const std::uint8_t choice = left_.back();
    left_ = left_.first(left_.size() - 1);
    constexpr std::uint8_t kInTime = 96;  // and below
    constexpr std::uint8_t kBusy = 240;   // from here on in steps of 5 ms, below up to 20 ms
    constexpr std::chrono::microseconds kStep{140};
    if (choice < kInTime) {
      return Duration{0};
    }
    return choice < kBusy ? Duration(kStep * (choice - kInTime))
                          : Duration(std::chrono::milliseconds(5) * (choice - kBusy + 4));
  }

 private:
  modbus::Bytes left_;
};

struct Asked {
  Pdu pdu;
  bool is_stop = false;
};

/// Of each function some that only their content tells apart.
inline const std::array<Asked, 16> kAsked{{
    {{0x03, 0x00, 0x00, 0x00, 0x01}},
    {{0x03, 0x00, 0x10, 0x00, 0x01}},
    {{0x04, 0x00, 0x00, 0x00, 0x01}},
    {{0x01, 0x00, 0x00, 0x00, 0x10}},
    {{0x06, 0x00, 0x00, 0x00, 0x01}},
    {{0x06, 0x00, 0x00, 0x00, 0x02}},
    {{0x10, 0x00, 0x00, 0x00, 0x01, 0x02, 0x00, 0x01}},  // its answer does not say which value
    {{0x10, 0x00, 0x00, 0x00, 0x01, 0x02, 0x00, 0x02}},
    {{0x06, 0x00, 0x7C, 0x00, 0xE1}, true},
    {{0x10, 0x00, 0x7C, 0x00, 0x01, 0x02, 0x00, 0xE1}, true},
    {{0x06, 0x00, 0x7C, 0x00, 0x66}},                    // a move, that a stop ends
    {{0x10, 0x00, 0x7C, 0x00, 0x01, 0x02, 0x00, 0x66}},  // and another one, answered like a stop
    {{0x17, 0x00, 0x00, 0x00, 0x01, 0x00, 0x20, 0x00, 0x01, 0x02, 0x00, 0x07}},
    {{0x17, 0x00, 0x10, 0x00, 0x01, 0x00, 0x20, 0x00, 0x01, 0x02, 0x00, 0x08}},
    {{0x05, 0x00, 0x01, 0xFF, 0x00}},
    {{0x41, 0x00, 0x01}},  // silence alone ends its answer
}};

inline bool is_read(const Pdu& pdu) { return pdu.front() <= 4; }

struct Scene {
  bus::BusSettings settings;
  std::vector<drive::Device> devices;
  bus::LineKind kind = bus::LineKind::virtual_line;
  bool hears_itself = false;
  bool collides = false;  ///< what is sent while a device answers, and that answer, are lost

  explicit Scene(Script& script);
  [[nodiscard]] const drive::DeviceTiming& timing() const { return settings.timing; }
};

inline Scene::Scene(Script& script) {
  using namespace std::chrono_literals;
  const std::uint8_t times = script.byte();
  const std::uint8_t repeats = script.byte();
  const std::uint8_t rules = script.byte();
  const std::uint8_t line = script.byte();
  constexpr std::array<Duration, 4> kTimeouts{100ms, 50ms, 20ms, 200ms};
  constexpr std::array<Duration, 4> kQuarantines{0ms, 10ms, 60ms, 300ms};
  constexpr std::array<Duration, 4> kGaps{0ms, 0ms, 5ms, 40ms};
  auto& timing = settings.timing;
  timing.response_timeout = kTimeouts.at(times % 4U);
  timing.probe_timeout = timing.response_timeout;
  if ((times & 0x10U) != 0) {
    timing.quarantine = kQuarantines.at((times >> 2U) % 4U);
  }
  // Longer than any quarantine here: an answer that comes at its end, and is judged behind it
  // because of noise, is otherwise taken for one that is owed to a later request.
  timing.quarantine_max = (times & 0x20U) != 0 ? Duration(2s) : Duration(10s);
  timing.gap = kGaps.at(times >> 6U);
  timing.retries = (repeats + 1U) % 4U;
  timing.retry_writes = (repeats & 0x04U) != 0;
  timing.stop_retries = (repeats >> 3U) % 4U;
  timing.offline_after = (repeats & 0x20U) != 0 ? 3 : 0;
  timing.probe_interval = 300ms;
  timing.response_wait = (repeats & 0xC0U) == 0xC0U ? 30ms : 0ms;
  settings.listen_first = 0ms;
  settings.hung_after = 0ms;
  settings.coalesce = (rules & 0x01U) != 0;
  settings.stop_wait = (rules & 0x02U) != 0 ? 20ms : 100ms;
  settings.settle = (rules & 0x04U) != 0 ? 10ms : 0ms;
  hears_itself = (line & 0x03U) == 0x03U;
  if (hears_itself || (line & 0x03U) == 0x02U) {
    settings.line.echo = hears_itself;
  }
  kind = (line & 0x04U) != 0 ? bus::LineKind::uart : bus::LineKind::virtual_line;
  collides = (line & 0x08U) != 0 || hears_itself;
  for (std::uint8_t address = 1; address <= 2; ++address) {
    auto& device = devices.emplace_back();
    device.name = "axis";
    device.address = address;
    device.timing = timing;
    device.profile.stops = {{.address = 0x007C, .value = 0x00E1}};
    device.stop_cancels = (rules & 0x08U) == 0;
  }
}

/// A request of a client, and when it comes.
struct Request {
  Instant at;
  std::uint8_t device = 1;
  std::uint8_t client = 0;
  Duration patience{0};
  std::vector<Asked> parts;
  bus::Job job{};
  unsigned endings = 0;

  [[nodiscard]] bool is_stop() const {
    return std::ranges::all_of(parts, [](const Asked& part) { return part.is_stop; });
  }
};

inline std::deque<Request> requests_of(Script& script, Instant now) {
  using namespace std::chrono_literals;
  constexpr std::array<Duration, 4> kPatience{60s, 60s, 1s, 200ms};
  constexpr std::uint8_t kLong = 224;  // steps of 16 ms, below of 2 ms
  std::deque<Request> requests;
  for (unsigned left = 2U + script.byte() % 5U; left > 0; --left) {
    const std::uint8_t what = script.byte();
    const std::uint8_t when = script.byte();
    const std::uint8_t whose = script.byte();
    now += when < kLong ? Duration(2ms * (when / 2)) : Duration(16ms * (when - kLong));
    Request& request = requests.emplace_back();
    request.at = now;
    request.device = (what & 0x10U) != 0 ? 2 : 1;
    request.client = static_cast<std::uint8_t>(requests.size() % 4U + whose % 2U);
    request.patience = kPatience.at((whose >> 1U) % 4U);
    request.parts.push_back(kAsked.at(what % 16U));
    if (whose >= 0xC0) {
      request.parts.push_back(kAsked.at((whose >> 2U) % 16U));
    }
  }
  return requests;
}

}  // namespace mbgate::fuzz::confusable
