// SPDX-License-Identifier: Apache-2.0
// What lies between a line and the kernel: it hands received bytes over late and in chunks of its
// own, at any place in a frame, but always in their order.
#pragma once

#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "soak/flight.hpp"
#include "soak/from_world.hpp"
#include "soak/plan.hpp"

namespace mbgate::soak {

/// What was heard at once.
struct Heard {
  std::vector<std::uint8_t> bytes;
  std::vector<HeardFrame> frames;
  std::optional<HeardEcho> echo{};  ///< that ends here
  bool strange_request = false;     ///< of another client, ends here
};

class Adapter {
 public:
  using HandOver = std::function<void(const Heard&)>;
  Adapter(AdapterKind kind, Schedule& schedule, Random& random, HandOver hand_over)
      : kind_(kind),
        schedule_(schedule),
        random_(random),
        hand_over_(std::move(hand_over)),
        phase_(random.duration(Duration{0}, kTick)) {}

  /// When bytes that are heard now will have reached the kernel.
  [[nodiscard]] Instant arrival();
  /// They were heard, and arrive then.
  void take(Heard heard, Instant arrival);
  /// It was pulled out, or the line is closed.
  void reset();
  /// From now on it is quick.
  void calm_down() { kind_ = AdapterKind::uart; }

 private:
  static constexpr Duration kTick = std::chrono::milliseconds(16);

  AdapterKind kind_;
  Schedule& schedule_;
  Random& random_;
  HandOver hand_over_;
  Duration phase_;
  Instant last_ = Instant::min();
  std::uint64_t epoch_ = 0;
};

}  // namespace mbgate::soak
