// SPDX-License-Identifier: Apache-2.0
// What is known of one device, and requests to it that are answered or not.
#pragma once

#include <gtest/gtest.h>

#include "bus/health/device_health.hpp"
#include "bus/health/hold.hpp"
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
    return at(time) >= hold_.until(timing_);
  }

  static modbus::Request request(std::string_view pdu) {
    return *modbus::Request::parse(*modbus::Pdu::from(unhex(pdu)));
  }
  [[nodiscard]] bool may_be_asked(const modbus::Request& asked, bus::Duration time) const {
    return at(time) >= hold_.until(asked, timing_, false);
  }
  /// `asked`, whose response timeout of 100 ms ends at `due`, is not answered in that time. True:
  /// it is offline now.
  bool unanswered(const modbus::Request& asked, bus::Duration due) {
    hold_.note_unanswered({asked, at(due - 100ms), at(due)});
    return health_.note_unanswered(at(due - 100ms), at(due), timing_.offline_after);
  }
  /// It is, after `took`. True: it was offline.
  bool answered(const modbus::Request& asked, const std::vector<std::uint8_t>& response,
                bus::Duration due, bus::Duration took) {
    const Instant now = at(due - 100ms + took);
    hold_.note_answered({asked, at(due - 100ms), at(due)}, response, took, now, timing_);
    health_.note_answered(at(due - 100ms));
    return health_.note_heard(now);
  }
  auto late(const std::vector<std::uint8_t>& response, bus::Duration came,
            bool was_offline = false) {
    return hold_.note_late(response, at(came), timing_, was_offline);
  }
  void asked(bus::Duration time) { hold_.note_asked(nullptr, at(time), timing_, false); }
  [[nodiscard]] std::size_t owed(const modbus::Request& next) const {
    return hold_.owed(next, 0, Instant::max(), at(0ms), timing_).size();
  }
  [[nodiscard]] bus::OwedAnswers owed_since(const modbus::Request& next, bus::Duration sent) const {
    return hold_.owed(next, 0, at(sent), at(0ms), timing_);
  }

  const std::vector<std::uint8_t> kAnswer = unhex("03 02 12 34");
  const std::vector<std::uint8_t> kEcho = unhex("06 0000 0001");
  const modbus::Request read_ = request("03 0000 0001");
  const modbus::Request other_read_ = request("03 0010 0001");
  const modbus::Request write_ = request("06 0000 0001");
  drive::DeviceTiming timing_;
  DeviceHealth health_;
  bus::Hold hold_;
};

}  // namespace mbgate::test
