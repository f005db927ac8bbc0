// SPDX-License-Identifier: Apache-2.0
// The register tables of MOONS' drives ("Modbus User Manual", Appendix 5), one a series. Register
// numbers there are references: protocol address = number - 40001.
#pragma once

#include <cstdint>
#include <optional>

#include "sim/drives/register_bank.hpp"

namespace mbgate::sim {

enum class MoonsSeries : std::uint8_t {
  st,    ///< ST, STAC, STM, SWM: steppers
  stb,   ///< STB
  stf,   ///< STF
  ssdc,  ///< SSDC, SS, RS, SSM, TSM, TXM: step servos
  m2,    ///< M2: servo; has write-only values
  m3,    ///< M3: servo with a map of its own, almost all values
  mdx,   ///< MDX
  bldc   ///< BLDC: turns, but does not position
};

RegisterMap moons_m3_registers();
RegisterMap moons_registers(MoonsSeries series);

/// Registers that all series except M3 have at the same address.
inline constexpr std::uint16_t kMoonsStatus = 0x0001;
inline constexpr std::uint16_t kMoonsPosition = 0x0006;
inline constexpr std::uint16_t kMoonsDistance = 0x001E;
/// Registers that all series have at the same address.
inline constexpr std::uint16_t kMoonsOpcode = 0x007C;
inline constexpr std::uint16_t kMoonsParameters = 0x007D;

/// The addresses of the registers of a series that do more than hold a value.
struct MoonsPlaces {
  std::uint16_t alarm = 0x0000;
  std::uint16_t status = kMoonsStatus;
  std::uint16_t encoder_position = 0x0004;
  std::uint16_t position = kMoonsPosition;
  std::optional<std::uint16_t> position_command = 0x0008;
  std::uint16_t velocity = 0x000A;
  std::uint16_t target_velocity = 0x000B;
  std::uint16_t relative_distance = 0x0013;
  std::uint16_t distance = kMoonsDistance;
  std::uint16_t jog_velocity = 0x0030;
  std::optional<std::uint16_t> protocol = std::nullopt;  ///< PR
  std::uint32_t status_bits = 0xFFFFFFFF;  ///< the status bits that the series has (Appendix 6)
};

const MoonsPlaces& moons_places(MoonsSeries series);

/// PR: word order and wiring in one setting (4.1.2).
inline constexpr std::uint16_t kMoonsProtocolLittle = 133;
/// The bit that is set in the two little-endian settings (133 and 389) and not in the two
/// big-endian ones (5 and 261).
inline constexpr std::uint32_t kMoonsLittleBit = 0x80;

}  // namespace mbgate::sim
