// SPDX-License-Identifier: Apache-2.0
// One request to one address of a bus, and its response. A plan is made of them; a bus carries them
// out.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "drive/device.hpp"
#include "modbus/request.hpp"

namespace mbgate::drive {

struct Transaction {
  // Not an aggregate: all its room would be filled with zeros first.
  Transaction(std::uint8_t to, const modbus::Request& asked, bool may_be_silent = false,
              std::optional<BroadcastForm> form = std::nullopt)
      : address(to), unit(to), request(asked), silence_is_success(may_be_silent), broadcast(form) {}

  BusId bus{};           ///< in a plan
  std::uint8_t address;  ///< of the device
  std::uint8_t unit;     ///< on the wire: another one on a TCP bus whose one device has every unit
  modbus::Request request;
  /// 08/01 and 08/04 silence a device: a missing answer is then not a failure.
  bool silence_is_success;
  /// Set: a broadcast in this form, which nobody answers.
  std::optional<BroadcastForm> broadcast;
  std::optional<modbus::Pdu> response = std::nullopt;
  /// Set by the bus for a write that its device carries out and never answers: how long the device
  /// does not listen afterwards.
  std::optional<Duration> boot_time = std::nullopt;
  /// Set for a check that the gateway adds, a read of one register: what follows is sent only if
  /// the register holds one of these values. Must outlive the job.
  const std::vector<std::uint16_t>* must_hold = nullptr;

  [[nodiscard]] bool is_broadcast() const { return broadcast.has_value(); }
  /// Is the same asked of the same device, by the same unit?
  [[nodiscard]] bool is_like(const Transaction& other) const {
    return address == other.address && unit == other.unit && broadcast == other.broadcast &&
           request.pdu() == other.request.pdu();
  }
  [[nodiscard]] bool may_stay_silent() const { return silence_is_success || boot_time; }
};

}  // namespace mbgate::drive
