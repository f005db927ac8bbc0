// SPDX-License-Identifier: Apache-2.0
// An Autonics AiC ("User Manual for Communication"): functions 01 to 06 and 16 over four tables,
// high word first, requests within one parameter group, answers delayed by the response waiting
// time of register 405204, and a broadcast form of its own. Moves take no time; continuous runs and
// programs last until they are stopped.
#pragma once

#include "sim/drives/maps/aic_map.hpp"
#include "sim/drives/register_service.hpp"

namespace mbgate::sim {

class AicDrive {
 public:
  /// 2.13: address 129 with the function OR 0x80. Address 0 is not heard.
  static constexpr std::uint8_t kBroadcastAddress = 129;

  AicDrive();

  Reaction answer(const modbus::Pdu& pdu);
  Reaction hear_broadcast(const modbus::Pdu& pdu);

  /// 1 to 99 ms, kept in register 405204.
  void set_response_wait(std::chrono::milliseconds wait);

  /// For tests: the state of the drive.
  [[nodiscard]] RegisterBank& bank(modbus::Table table);

 private:
  modbus::Pdu respond(const modbus::Request& request);
  modbus::Pdu write(const modbus::Request& request);
  void command(std::uint16_t coil);
  void move_to(std::uint32_t position);
  void set_mode(std::uint16_t mode);
  void set_emergency(bool stopped);
  void copy_settings_to_registers();
  void copy_settings_to_coils();
  [[nodiscard]] Duration response_wait() const;

  RegisterBank coils_;
  RegisterBank discrete_inputs_;
  RegisterBank holding_;
  RegisterBank input_;
};

}  // namespace mbgate::sim
