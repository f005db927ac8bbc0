// SPDX-License-Identifier: Apache-2.0
#include "sim/drives/aic_drive.hpp"

namespace mbgate::sim {
namespace {

using modbus::Table;

constexpr RegisterRules kAicRules{.most_read = 123, .most_written = 123};  // 2.13
constexpr std::uint16_t kMostBroadcastRegisters = 2;                       // 2.13

// Run modes of register 301000.
constexpr std::uint16_t kWaiting = 0;
constexpr std::uint16_t kIndex = 1;
constexpr std::uint16_t kContinuous = 3;
constexpr std::uint16_t kProgram = 4;

constexpr std::uint32_t kEmergencyStopError = 1U << 13U;  // 301011
constexpr std::uint32_t kAlarmOutput = 1U << 0U;          // 301015

std::optional<modbus::TableRange> range_of(const modbus::Request& request) {
  if (request.reads()) {
    return request.reads()->range;
  }
  return request.writes() ? std::optional(request.writes()->range) : std::nullopt;
}

// 2.13: command coils and communication registers.
bool may_be_broadcast(const modbus::TableRange& range) {
  const std::uint32_t last = std::uint32_t{range.first} + range.count - 1;
  if (range.table == Table::coils) {
    return range.first >= kAicFirstCommand && last <= kAicLastCommand;
  }
  return range.first >= kAicFirstCommunication && last <= kAicLastCommunication &&
         range.count <= kMostBroadcastRegisters;
}

}  // namespace

AicDrive::AicDrive()
    : coils_(aic_registers(Table::coils), drive::WordOrder::big),
      discrete_inputs_(aic_registers(Table::discrete_inputs), drive::WordOrder::big),
      holding_(aic_registers(Table::holding_registers), drive::WordOrder::big),
      input_(aic_registers(Table::input_registers), drive::WordOrder::big) {}

Reaction AicDrive::answer(const modbus::Pdu& pdu) {
  // The wait that was in force when the request came: a new one counts from the next on.
  const Duration wait = response_wait();
  const auto request = request_of(pdu, {0x01, 0x02, 0x03, 0x04, 0x05, 0x06, 0x10});
  Reaction reaction = request ? Reaction{respond(*request)} : request.error();
  reaction.delay = wait;
  return reaction;
}

Reaction AicDrive::hear_broadcast(const modbus::Pdu& pdu) {
  const std::uint8_t function = pdu.function();
  if (function != 0x85 && function != 0x86 && function != 0x90) {
    return {};
  }
  std::vector<std::uint8_t> bytes(pdu.bytes().begin(), pdu.bytes().end());
  bytes[0] = static_cast<std::uint8_t>(function & ~modbus::kExceptionBit);
  const auto request = modbus::Request::parse(*modbus::Pdu::from(bytes));
  if (request && may_be_broadcast(request->writes()->range)) {
    write(*request);
  }
  return {};
}

void AicDrive::set_response_wait(std::chrono::milliseconds wait) {
  holding_.set(kAicResponseWait, static_cast<std::uint32_t>(wait.count()));
}

RegisterBank& AicDrive::bank(Table table) {
  switch (table) {
    case Table::coils: return coils_;
    case Table::discrete_inputs: return discrete_inputs_;
    case Table::holding_registers: return holding_;
    case Table::input_registers: return input_;
  }
  return holding_;
}

modbus::Pdu AicDrive::respond(const modbus::Request& request) {
  const modbus::TableRange range = *range_of(request);
  if (range.count > kAicRules.most_read) {
    return exception(request.function(), kAicRules.too_many);
  }
  const auto in_group = aic_stays_in_group(range);
  if (!in_group) {
    return exception(request.function(), kAicRules.no_such_register);
  }
  if (!*in_group) {
    return exception(request.function(), kAicRules.too_many);  // 2.13: error code 03
  }
  return request.reads() ? serve_read(request, bank(range.table), kAicRules) : write(request);
}

modbus::Pdu AicDrive::write(const modbus::Request& request) {
  const modbus::TableRange& range = request.writes()->range;
  const modbus::Pdu response = serve_write(request, bank(range.table), kAicRules);
  if (response.is_exception()) {
    return response;
  }
  if (range.table == Table::holding_registers) {
    copy_settings_to_coils();
  } else if (range.first >= kAicFirstSetting) {
    copy_settings_to_registers();
  } else if (range.first >= kAicFirstCommand && coils_.get(range.first) == 1) {
    command(range.first);
  }
  return response;
}

void AicDrive::command(std::uint16_t coil) {
  coils_.set(coil, 0);
  const std::uint32_t target = holding_.get(kAicPositionToMove);
  switch (coil) {
    case kAicReset:
    case kAicAlarmReset: set_emergency(false); break;
    case kAicEmergencyStop: set_emergency(true); break;
    case kAicClearCommandPosition: input_.set(kAicCommandPosition, 0); break;
    case kAicClearActualPosition: input_.set(kAicActualPosition, 0); break;
    case kAicRunClockwise:
    case kAicRunCounterclockwise: set_mode(kContinuous); break;
    case kAicMoveAbsolute: move_to(target); break;
    case kAicMoveRelative: move_to(input_.get(kAicCommandPosition) + target); break;
    case kAicStartIndex: set_mode(kIndex); break;
    case kAicStartProgram: set_mode(kProgram); break;
    case kAicHomeSearch: move_to(0); break;
    case kAicImmediateStop:
    case kAicDeceleratingStop:
    case kAicPauseProgram:
    case kAicEndProgram: set_mode(kWaiting); break;
    case kAicDeleteProgram:
      for (std::uint16_t i = 0; i < kAicStepRegisters; ++i) {
        holding_.set(static_cast<std::uint16_t>(kAicFirstStep + i), 0);
      }
      break;
    default: break;
  }
}

void AicDrive::move_to(std::uint32_t position) {
  input_.set(kAicCommandPosition, position);
  input_.set(kAicActualPosition, position);
  set_mode(kWaiting);
}

void AicDrive::set_mode(std::uint16_t mode) { input_.set(kAicRunMode, mode); }

void AicDrive::set_emergency(bool stopped) {
  set_mode(kWaiting);
  input_.set(kAicErrors, stopped ? kEmergencyStopError : 0);
  const std::uint32_t outputs = input_.get(kAicOutputs);
  input_.set(kAicOutputs, stopped ? outputs | kAlarmOutput : outputs & ~kAlarmOutput);
  discrete_inputs_.set(kAicAlarmInput, stopped ? 1 : 0);
}

void AicDrive::copy_settings_to_registers() {
  for (std::uint16_t bit = 0; kAicFirstSetting + bit <= kAicLastSetting; ++bit) {
    const auto address = static_cast<std::uint16_t>(kAicSettingBits + bit / 16);
    const std::uint32_t mask = 1U << (bit % 16U);
    const bool on = coils_.get(static_cast<std::uint16_t>(kAicFirstSetting + bit)) == 1;
    const std::uint32_t others = holding_.get(address) & ~mask;
    holding_.set(address, on ? others | mask : others);
  }
}

void AicDrive::copy_settings_to_coils() {
  for (std::uint16_t bit = 0; kAicFirstSetting + bit <= kAicLastSetting; ++bit) {
    const auto address = static_cast<std::uint16_t>(kAicSettingBits + bit / 16);
    coils_.set(static_cast<std::uint16_t>(kAicFirstSetting + bit),
               (holding_.get(address) >> (bit % 16U)) & 1U);
  }
}

Duration AicDrive::response_wait() const {
  return std::chrono::milliseconds(holding_.get(kAicResponseWait));
}

}  // namespace mbgate::sim
