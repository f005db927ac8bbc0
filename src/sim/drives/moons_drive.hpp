// SPDX-License-Identifier: Apache-2.0
// A MOONS' drive on RS-485 or Ethernet ("Modbus User Manual"): functions 03, 06 and 16, at most 50
// registers, exceptions of its own, values in the word order set by PR, motion by opcodes. Moves
// take no time; jogging lasts until it is stopped.
#pragma once

#include "drive/values.hpp"
#include "sim/drives/maps/moons_map.hpp"
#include "sim/drives/register_service.hpp"

namespace mbgate::sim {

class MoonsDrive {
 public:
  /// 4.1.2: received by every drive, writes only, never answered.
  static constexpr std::uint8_t kBroadcastAddress = 0;

  MoonsDrive(MoonsSeries series, drive::WordOrder order);

  Reaction answer(const modbus::Pdu& pdu);
  Reaction hear_broadcast(const modbus::Pdu& pdu);

  /// For tests: the state of the drive, independent of its word order.
  [[nodiscard]] RegisterBank& registers() { return registers_; }

 private:
  modbus::Pdu write(const modbus::Request& request);
  [[nodiscard]] bool knows_opcode(const modbus::Request& request) const;
  void execute(std::uint16_t opcode);
  void stand_still();
  void move_to(std::uint32_t position);
  void set_position(std::uint32_t position);
  void start_jogging();
  void take_word_order();
  /// Parameters 1 and 2 as one position (opcodes EP and SP).
  [[nodiscard]] std::uint32_t position_parameter() const;
  void change_status(std::uint32_t clear, std::uint32_t set);

  MoonsPlaces places_;
  drive::WordOrder order_;
  RegisterBank registers_;
};

}  // namespace mbgate::sim
