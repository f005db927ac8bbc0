// SPDX-License-Identifier: Apache-2.0
// What is known of one device, and requests to it that are answered or not.
#pragma once

#include <gtest/gtest.h>

#include "bus/health/device_health.hpp"
#include "support/hex.hpp"

namespace mbgate::test {

using namespace std::chrono_literals;
using bus::DeviceHealth;
using bus::DeviceState;
using bus::Instant;

class Health : public testing::Test {
 protected:
  Health() { timing_.response_timeout = 100ms; }
  static Instant at(bus::Duration time) { return Instant{} + time; }
  [[nodiscard]] bool may_be_asked(bus::Duration time) const {
    return at(time) >= health_.held_until(timing_);
  }

  static modbus::Request request(std::string_view pdu) {
    return *modbus::Request::parse(*modbus::Pdu::from(unhex(pdu)));
  }
  [[nodiscard]] bool may_be_asked(const modbus::Request& asked, bus::Duration time) const {
    return at(time) >= health_.held_until(asked.function(), timing_);
  }

  /// `asked`, whose response timeout of 100 ms ends at `due`, is not answered in that time.
  bool unanswered(const modbus::Request& asked, bus::Duration due) {
    return health_.note_unanswered(asked, at(due - 100ms), at(due), timing_);
  }
  /// It is, after `took`, which is handled at `now`.
  bool answered(const modbus::Request& asked, const std::vector<std::uint8_t>& response,
                bus::Duration due, bus::Duration took, bus::Duration now) {
    return health_.note_answered({asked, response, at(due - 100ms), at(due), took}, at(now));
  }

  const std::vector<std::uint8_t> kAnswer = unhex("03 02 12 34");
  const modbus::Request read_ = request("03 0000 0001");
  const modbus::Request write_ = request("06 0000 0001");
  drive::DeviceTiming timing_;
  DeviceHealth health_;
};

}  // namespace mbgate::test
