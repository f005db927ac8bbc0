// SPDX-License-Identifier: Apache-2.0
// A HIGEN FDA6000 ("Std. MODBUS PROTOCOL"), on RTU or ASCII: functions 03, 06 and 16 over 16-bit
// registers, functions of its own that it only echoes, and the exceptions 05 to 07. Restoring the
// parameters takes long: it is acknowledged with 05, and everything else is refused with 06 until
// it is done. Motion is not simulated.
#pragma once

#include "sim/drives/maps/fda6000_map.hpp"
#include "sim/drives/register_service.hpp"

namespace mbgate::sim {

class Fda6000Drive {
 public:
  /// The manual does not mention broadcasts, so none is obeyed.
  static constexpr std::uint8_t kBroadcastAddress = 0;
  /// The manual gives no figure for a long command (7.4).
  static constexpr Duration kParameterInitTime = std::chrono::milliseconds(300);

  Fda6000Drive();

  Reaction answer(const modbus::Pdu& pdu);
  static Reaction hear_broadcast(const modbus::Pdu& pdu);

  /// For tests: the state of the drive.
  [[nodiscard]] RegisterBank& registers() { return registers_; }

 private:
  Reaction write(const modbus::Request& request);
  [[nodiscard]] std::optional<Refusal> store(std::uint16_t first, const Registers& words);

  RegisterBank registers_;
};

}  // namespace mbgate::sim
