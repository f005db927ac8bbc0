// SPDX-License-Identifier: Apache-2.0
// The register tables of MOONS' drives ("Modbus User Manual", Appendix 5), one a series. Register
// numbers there are references: protocol address = number - 40001.
#pragma once

#include <cstdint>

#include "sim/register_bank.hpp"

namespace mbgate::sim {

enum class MoonsSeries : std::uint8_t {
  st,  ///< ST, STAC, STM, SWM: steppers
  m2   ///< M2: servo; has write-only values and communication registers
};

RegisterMap moons_registers(MoonsSeries series);

/// Registers with a meaning beyond their value.
inline constexpr std::uint16_t kMoonsAlarm = 0x0000;
inline constexpr std::uint16_t kMoonsStatus = 0x0001;
inline constexpr std::uint16_t kMoonsEncoderPosition = 0x0004;
inline constexpr std::uint16_t kMoonsPosition = 0x0006;
inline constexpr std::uint16_t kMoonsPositionCommand = 0x0008;
inline constexpr std::uint16_t kMoonsVelocity = 0x000A;
inline constexpr std::uint16_t kMoonsTargetVelocity = 0x000B;
inline constexpr std::uint16_t kMoonsRelativeDistance = 0x0013;
inline constexpr std::uint16_t kMoonsDistance = 0x001E;
inline constexpr std::uint16_t kMoonsJogVelocity = 0x0030;
inline constexpr std::uint16_t kMoonsOpcode = 0x007C;
inline constexpr std::uint16_t kMoonsParameters = 0x007D;
inline constexpr std::uint16_t kMoonsProtocol = 0x00B0;  ///< PR, where the series has it

/// PR: word order and wiring in one setting (4.1.2).
inline constexpr std::uint16_t kMoonsProtocolBig = 5;
inline constexpr std::uint16_t kMoonsProtocolLittle = 133;

}  // namespace mbgate::sim
