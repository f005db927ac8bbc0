// SPDX-License-Identifier: Apache-2.0
#include "bus/durations.hpp"

#include <algorithm>
#include <bit>

namespace mbgate::bus {
namespace {

using namespace std::chrono_literals;

// Four steps for each doubling of this.
constexpr Duration kUnit = std::chrono::microseconds(16);
constexpr unsigned kStepsPerDoubling = 4;
// When so many are counted, all counts are halved: what was long ago fades.
constexpr unsigned kMostCounted = 2000;

// Values 0 to 7 have a step each; from there on the two bits after the highest one choose it.
std::size_t step_of(Duration duration) {
  const auto units = static_cast<std::uint64_t>(std::max(duration, Duration{0}) / kUnit);
  if (units < kStepsPerDoubling) {
    return static_cast<std::size_t>(units);
  }
  const auto exponent = static_cast<unsigned>(std::bit_width(units)) - 1U;
  const auto place = static_cast<unsigned>(units >> (exponent - 2U)) & (kStepsPerDoubling - 1U);
  return std::size_t{kStepsPerDoubling} * (exponent - 1U) + place;
}

Duration end_of_step(std::size_t step) {
  const std::size_t next = step + 1;
  if (next < kStepsPerDoubling) {
    return kUnit * static_cast<Duration::rep>(next);
  }
  const std::size_t exponent = next / kStepsPerDoubling + 1;
  const std::size_t begin = kStepsPerDoubling + next % kStepsPerDoubling;
  return kUnit * static_cast<Duration::rep>(begin << (exponent - 2U));
}

}  // namespace

constinit const std::array<Duration, 14> kLatencyBounds = {
    500us, 1ms, 2ms, 5ms, 10ms, 20ms, 50ms, 100ms, 200ms, 500ms, 1s, 2s, 5s, 10s};

void Durations::note(Duration duration) {
  ++counts_[std::min(step_of(duration), kSteps - 1)];
  if (++all_ < kMostCounted) {
    return;
  }
  all_ = 0;
  for (std::uint16_t& count : counts_) {
    count = static_cast<std::uint16_t>(count / 2U);
    all_ += count;
  }
}

std::optional<Duration> Durations::percentile(unsigned percent) const {
  if (all_ == 0) {
    return std::nullopt;
  }
  constexpr unsigned kPercent = 100;
  const unsigned wanted = (all_ * percent + kPercent - 1) / kPercent;
  unsigned seen = 0;
  for (std::size_t step = 0; step + 1 < kSteps; ++step) {
    seen += counts_[step];
    if (seen >= wanted) {
      return end_of_step(step);
    }
  }
  return end_of_step(kSteps - 1);
}

}  // namespace mbgate::bus
