// SPDX-License-Identifier: Apache-2.0
// Durations on a serial line, computed from its baud rate and character format. No clock: lengths
// of time only.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace mbgate::modbus {

using Duration = std::chrono::nanoseconds;

/// Bits a second.
enum class Baud : std::uint32_t {};

enum class Parity : std::uint8_t { none, even, odd };

struct CharacterFormat {
  unsigned data_bits = 8;
  Parity parity = Parity::even;
  unsigned stop_bits = 1;
  /// Bits a character takes on the wire, start bit included.
  [[nodiscard]] unsigned bits() const {
    return 1 + data_bits + (parity == Parity::none ? 0U : 1U) + stop_bits;
  }
  friend bool operator==(const CharacterFormat&, const CharacterFormat&) = default;
};

/// "8E1"
std::string format_text(const CharacterFormat& format);

/// Above this rate t3.5 is fixed (Serial Line V1.02, 2.5.1.1).
inline constexpr Baud kFixedTimersAbove{19200};
inline constexpr Duration kFixedT35 = std::chrono::microseconds(1750);

class RtuTiming {
 public:
  /// `baud` must not be 0.
  RtuTiming(Baud baud, CharacterFormat format);

  /// How long `bytes` contiguous characters take.
  [[nodiscard]] Duration duration_of(std::size_t bytes) const;
  /// What so many characters take at least on a wire whose clock may be fast, and whose characters
  /// may be shorter than ours: of 10 bits, less 3 %.
  [[nodiscard]] Duration least_duration_of(std::size_t bytes) const;
  /// The inter-frame silence: 3.5 characters up to 19200 baud, 1.750 ms above.
  [[nodiscard]] Duration t3_5() const { return t3_5_; }

 private:
  std::uint64_t baud_;
  std::uint64_t bits_;
  Duration t3_5_;
};

}  // namespace mbgate::modbus
