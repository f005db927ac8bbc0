// SPDX-License-Identifier: Apache-2.0
#include "modbus/rtu_timing.hpp"

#include <algorithm>
#include <fmt/core.h>
#include <string_view>

namespace mbgate::modbus {
namespace {

constexpr std::uint64_t kNanoseconds = 1'000'000'000;

// Rounded up: a silence must not be shorter than asked for.
Duration time_of_half_bits(std::uint64_t half_bits, std::uint64_t baud) {
  return Duration((half_bits * kNanoseconds + 2 * baud - 1) / (2 * baud));
}

}  // namespace

std::string format_text(const CharacterFormat& format) {
  constexpr std::string_view kParities = "NEO";
  return fmt::format("{}{}{}", format.data_bits, kParities[static_cast<std::size_t>(format.parity)],
                     format.stop_bits);
}

RtuTiming::RtuTiming(Baud baud, CharacterFormat format)
    : baud_(static_cast<std::uint32_t>(baud)),
      bits_(format.bits()),
      t3_5_(baud > kFixedTimersAbove ? kFixedT35 : time_of_half_bits(7 * bits_, baud_)) {}

Duration RtuTiming::duration_of(std::size_t bytes) const {
  return time_of_half_bits(2 * bits_ * bytes, baud_);
}

Duration RtuTiming::least_duration_of(std::size_t bytes) const {
  constexpr std::uint64_t kShortCharacter = 10;
  return time_of_half_bits(2 * std::min(bits_, kShortCharacter) * bytes, baud_) * 97 / 100;
}

}  // namespace mbgate::modbus
