// SPDX-License-Identifier: Apache-2.0
// The address map of the HIGEN FDA6000 ("Std. MODBUS PROTOCOL", section 10). All registers have 16
// bits; what is printed as Float is transmitted times ten, and '#' marks signed registers.
#pragma once

#include <cstdint>

#include "sim/drives/register_bank.hpp"

namespace mbgate::sim {

RegisterMap fda6000_registers();

/// P1-01 to P1-14: 0xFFFF written there means "leave it as it is" (6.4).
inline constexpr std::uint16_t kFdaFirstMasked = 0x0064;
inline constexpr std::uint16_t kFdaLastMasked = 0x0071;
inline constexpr std::uint16_t kFdaMask = 0xFFFF;

/// P2-24: 1 restores the parameters.
inline constexpr std::uint16_t kFdaParameterInit = 0x00DF;
/// P5-01: the first of 32 positions.
inline constexpr std::uint16_t kFdaFirstPosition = 0x01F4;
/// OPR CMD (9.3). The frame there says 0x044C, the number beside it would be another register.
inline constexpr std::uint16_t kFdaOperatorCommand = 0x044C;

}  // namespace mbgate::sim
