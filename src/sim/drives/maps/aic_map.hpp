// SPDX-License-Identifier: Apache-2.0
// The mapping table of the Autonics AiC ("User Manual for Communication", section 2): four tables,
// in groups that a request must not leave. The addresses in brackets there are protocol addresses.
#pragma once

#include <cstdint>
#include <optional>

#include "modbus/request.hpp"
#include "sim/drives/register_bank.hpp"

namespace mbgate::sim {

RegisterMap aic_registers(modbus::Table table);

/// Does the request stay in the parameter group in which it begins (2.13)? Nothing if it begins
/// outside all groups.
std::optional<bool> aic_stays_in_group(const modbus::TableRange& range);

/// Command coils (2.2; 2.13 misprints the addresses of the last six).
inline constexpr std::uint16_t kAicFirstCommand = 0x000A;
inline constexpr std::uint16_t kAicReset = 0x000A;
inline constexpr std::uint16_t kAicEmergencyStop = 0x000B;
inline constexpr std::uint16_t kAicAlarmReset = 0x000C;
inline constexpr std::uint16_t kAicClearCommandPosition = 0x000D;
inline constexpr std::uint16_t kAicClearActualPosition = 0x000E;
inline constexpr std::uint16_t kAicRunClockwise = 0x000F;
inline constexpr std::uint16_t kAicRunCounterclockwise = 0x0010;
inline constexpr std::uint16_t kAicMoveAbsolute = 0x0011;
inline constexpr std::uint16_t kAicMoveRelative = 0x0012;
inline constexpr std::uint16_t kAicStartIndex = 0x0013;
inline constexpr std::uint16_t kAicStartProgram = 0x0014;
inline constexpr std::uint16_t kAicHomeSearch = 0x0015;
inline constexpr std::uint16_t kAicImmediateStop = 0x0016;
inline constexpr std::uint16_t kAicDeceleratingStop = 0x0017;
inline constexpr std::uint16_t kAicPauseProgram = 0x0018;
inline constexpr std::uint16_t kAicEndProgram = 0x0019;
inline constexpr std::uint16_t kAicDeleteProgram = 0x001A;
inline constexpr std::uint16_t kAicLastCommand = 0x001A;

/// Setting coils 0x001E to 0x0041 (2.3) are the bits of these registers (2.9).
inline constexpr std::uint16_t kAicFirstSetting = 0x001E;
inline constexpr std::uint16_t kAicLastSetting = 0x0041;
inline constexpr std::uint16_t kAicSettingBits = 0x1388;

/// Discrete inputs (2.4).
inline constexpr std::uint16_t kAicAlarmInput = 0x001D;

/// Input registers (2.6).
inline constexpr std::uint16_t kAicRunMode = 0x03E7;
inline constexpr std::uint16_t kAicCommandPosition = 0x03E8;
inline constexpr std::uint16_t kAicActualPosition = 0x03EA;
inline constexpr std::uint16_t kAicErrors = 0x03F2;
inline constexpr std::uint16_t kAicOutputs = 0x03F6;

/// Holding registers (2.7, 2.8, 2.12).
inline constexpr std::uint16_t kAicPositionToMove = 0x0008;
inline constexpr std::uint16_t kAicFirstStep = 0x0032;
inline constexpr std::uint16_t kAicStepRegisters = 2560;
inline constexpr std::uint16_t kAicFirstCommunication = 0x1450;
inline constexpr std::uint16_t kAicLastCommunication = 0x1453;
inline constexpr std::uint16_t kAicResponseWait = 0x1453;

}  // namespace mbgate::sim
