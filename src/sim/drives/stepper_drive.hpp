// SPDX-License-Identifier: Apache-2.0
// The RS-485 stepper ("RS485 Communication Manual"): functions 03, 04 (one register), 06 and 16,
// values low word first. A restart is never answered, and the drive receives nothing for a while.
// Saving takes time. Moves take no time; running and jogging last until they are stopped.
#pragma once

#include "sim/drives/maps/stepper_map.hpp"
#include "sim/drives/register_service.hpp"

namespace mbgate::sim {

class StepperDrive {
 public:
  /// Section V: received by every drive, never answered.
  static constexpr std::uint8_t kBroadcastAddress = 0;
  /// The manual gives no figure; half a second is usual for such controllers.
  static constexpr Duration kBootTime = std::chrono::milliseconds(500);
  /// 0x00DC takes about a tenth of a second (line 2051). The simulated drive takes a little more,
  /// so that a wait of exactly 100 ms is found to be too short.
  static constexpr Duration kSaveTime = std::chrono::milliseconds(120);

  StepperDrive();

  Reaction answer(const modbus::Pdu& pdu);
  Reaction hear_broadcast(const modbus::Pdu& pdu);

  /// For tests: the state of the drive, independent of its word order.
  [[nodiscard]] RegisterBank& registers() { return registers_; }

 private:
  Reaction write(const modbus::Request& request);
  void execute(const modbus::TableRange& written);
  void execute_motion(const modbus::TableRange& written);
  Reaction restart();
  void set_running(bool running);
  void move_to(std::uint32_t position);
  [[nodiscard]] std::uint32_t pulses_of_duration() const;

  RegisterBank registers_;
};

}  // namespace mbgate::sim
