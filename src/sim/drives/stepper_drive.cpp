// SPDX-License-Identifier: Apache-2.0
#include "sim/drives/stepper_drive.hpp"

#include <algorithm>
#include <array>

namespace mbgate::sim {
namespace {

// The manual states no exceptions; the standard's are answered. A table command carries at most 200
// bytes (line 1577), a read whatever a frame holds.
constexpr RegisterRules kStepperRules{.most_read = 125, .most_written = 100};
constexpr RegisterRules kSingleRules{.most_read = 1, .most_written = 0};

constexpr std::array<std::uint32_t, 4> kRunCommands{0, 1, 256, 257};  // line 1866
constexpr std::uint32_t kStepperRunning = 0x0300;                     // status bits 8 and 9
constexpr std::uint32_t kRestartBits = 0xFF00;

}  // namespace

StepperDrive::StepperDrive() : registers_(stepper_registers(), drive::WordOrder::little) {}

Reaction StepperDrive::answer(const modbus::Pdu& pdu) {
  const auto request = request_of(pdu, {0x03, 0x04, 0x06, 0x10});
  if (!request) {
    return request.error();
  }
  if (request->writes()) {
    return write(*request);
  }
  return {serve_read(*request, registers_, pdu.function() == 0x04 ? kSingleRules : kStepperRules)};
}

Reaction StepperDrive::hear_broadcast(const modbus::Pdu& pdu) {
  if (pdu.function() != 0x06 && pdu.function() != 0x10) {
    return {};
  }
  Reaction reaction = answer(pdu);
  reaction.response.reset();
  return reaction;
}

Reaction StepperDrive::write(const modbus::Request& request) {
  const modbus::TableRange& written = request.writes()->range;
  const modbus::Pdu response = serve_write(request, registers_, kStepperRules);
  if (response.is_exception()) {
    return {response};
  }
  if (touches(written, kStepperRun) &&
      std::ranges::find(kRunCommands, registers_.get(kStepperRun)) == kRunCommands.end()) {
    return {exception(request.function(), kStepperRules.out_of_range)};
  }
  if (touches(written, kStepperRestart) && (registers_.get(kStepperRestart) & kRestartBits) != 0) {
    return restart();
  }
  execute(written);
  execute_motion(written);
  return {response, touches(written, kStepperSave) ? kSaveTime : Duration{0}};
}

void StepperDrive::execute(const modbus::TableRange& written) {
  if (touches(written, kStepperRun)) {
    set_running((registers_.get(kStepperRun) & 1U) != 0);
  }
  if (touches(written, kStepperJog)) {
    set_running((registers_.get(kStepperJog) & 1U) != 0);
  }
  if (touches(written, kStepperTorqueRun)) {
    set_running((registers_.get(kStepperTorqueRun) & 1U) != 0);
  }
  if (touches(written, kStepperProgram)) {
    set_running(registers_.get(kStepperProgram) != 0);
  }
  if (touches(written, kStepperClearAlarms)) {
    registers_.set(kStepperAlarms, 0);
  }
  if (touches(written, kStepperSave) && registers_.get(kStepperSave) == 0) {
    registers_.restore_initial();
  }
}

void StepperDrive::execute_motion(const modbus::TableRange& written) {
  const auto value_written = [&written](std::uint16_t first) {
    return touches(written, first) || touches(written, static_cast<std::uint16_t>(first + 1));
  };
  const std::uint32_t here = registers_.get(kStepperPosition);
  if (touches(written, kStepperHoming)) {
    move_to(0);
  }
  if (value_written(kStepperRunDuration)) {
    move_to(here + pulses_of_duration());
  }
  if (value_written(kStepperRunPulses)) {
    move_to(here + registers_.get(kStepperRunPulses));
  }
  if (value_written(kStepperRunPulsesAnyTime)) {
    move_to(here + registers_.get(kStepperRunPulsesAnyTime));
  }
  if (value_written(kStepperRunTo)) {
    move_to(registers_.get(kStepperRunTo));
  }
  if (value_written(kStepperRunToAnyTime)) {
    move_to(registers_.get(kStepperRunToAnyTime));
  }
  if (value_written(kStepperSetPosition)) {
    registers_.set(kStepperPosition, registers_.get(kStepperSetPosition));
  }
}

// What is kept in memory stays; position and motion are lost with the supply.
Reaction StepperDrive::restart() {
  set_running(false);
  registers_.set(kStepperPosition, 0);
  return {std::nullopt, Duration{0}, kBootTime};
}

void StepperDrive::set_running(bool running) {
  const std::uint32_t others = registers_.get(kStepperStatus) & ~(kStepperRunning | kAtPosition);
  registers_.set(kStepperStatus, others | (running ? kStepperRunning : kAtPosition));
  registers_.set(kStepperRealSpeed, running ? registers_.get(kStepperSpeed) : 0);
}

void StepperDrive::move_to(std::uint32_t position) {
  set_running(false);
  registers_.set(kStepperPosition, position);
}

// Milliseconds at 0.01 turns a minute, in pulses; the sign of the duration is the direction (lines
// 1905 ff.).
std::uint32_t StepperDrive::pulses_of_duration() const {
  const auto milliseconds = static_cast<std::int32_t>(registers_.get(kStepperRunDuration));
  const auto speed = static_cast<std::int32_t>(registers_.get(kStepperSpeed));
  const auto turns = static_cast<double>(milliseconds) * speed / (60'000.0 * 100.0);
  const auto pulses = static_cast<std::int64_t>(turns * registers_.get(kStepperMicrosteps));
  return static_cast<std::uint32_t>(pulses);
}

}  // namespace mbgate::sim
