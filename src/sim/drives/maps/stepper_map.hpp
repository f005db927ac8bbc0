// SPDX-License-Identifier: Apache-2.0
// The register list of the RS-485 stepper ("RS485 Communication Manual", section VII).
#pragma once

#include <cstdint>

#include "sim/drives/register_bank.hpp"

namespace mbgate::sim {

RegisterMap stepper_registers();

/// Bit 12 of the status register: in position.
inline constexpr std::uint32_t kAtPosition = 0x1000;

/// Registers that do more than hold a value.
inline constexpr std::uint16_t kStepperPosition = 0x0004;
inline constexpr std::uint16_t kStepperStatus = 0x0006;
inline constexpr std::uint16_t kStepperMicrosteps = 0x0024;
inline constexpr std::uint16_t kStepperAlarms = 0x00A3;
inline constexpr std::uint16_t kStepperClearAlarms = 0x00A4;
inline constexpr std::uint16_t kStepperRun = 0x00C8;
inline constexpr std::uint16_t kStepperHoming = 0x00C9;
inline constexpr std::uint16_t kStepperJog = 0x00CA;
inline constexpr std::uint16_t kStepperTorqueRun = 0x00CB;
inline constexpr std::uint16_t kStepperRunDuration = 0x00CC;
inline constexpr std::uint16_t kStepperRunPulses = 0x00CE;
inline constexpr std::uint16_t kStepperRunTo = 0x00D0;
inline constexpr std::uint16_t kStepperSetPosition = 0x00D2;
inline constexpr std::uint16_t kStepperRestart = 0x00D4;
inline constexpr std::uint16_t kStepperRealSpeed = 0x00D6;
inline constexpr std::uint16_t kStepperSpeed = 0x00D8;
inline constexpr std::uint16_t kStepperProgram = 0x00DB;
inline constexpr std::uint16_t kStepperSave = 0x00DC;
inline constexpr std::uint16_t kStepperRunPulsesAnyTime = 0x00DE;
inline constexpr std::uint16_t kStepperRunToAnyTime = 0x00E8;

}  // namespace mbgate::sim
