// SPDX-License-Identifier: Apache-2.0
// An echo alone, without a line.
#pragma once

#include <gmock/gmock.h>

#include <vector>

#include "bus/serial/echo.hpp"
#include "echo_rig.hpp"
#include "modbus/frames.hpp"

namespace mbgate::test {

using namespace std::chrono_literals;
using bus::Instant;
using bus::LineFault;
using testing::ElementsAre;
using testing::IsEmpty;

inline constexpr auto kReadPdu = "03 0000 0001";
inline constexpr auto kSentRead = "01 03 00 00 00 01 84 0A";
inline constexpr auto kSentWrite = "01 06 00 00 00 01 48 0A";

class Echo : public testing::Test {
 protected:
  void begin(std::optional<bool> setting) { echo_.emplace(setting, counters_, faults_); }
  void send(std::string_view request, Instant now = {}) {
    const auto pdu = modbus::Pdu::from(unhex(request));
    transaction_.emplace(bus::Transaction{1, *modbus::Request::parse(*pdu)});
    const auto frame = modbus::encode_rtu(1, *pdu);
    echo_->expect(*transaction_, {frame.begin(), frame.end()}, now, now + 1s);
  }
  /// What is given on: what was held back until now, a bar, and the rest.
  std::string take(std::string_view bytes, Instant now = {}) {
    const auto given = unhex(bytes);
    const auto heard = echo_->take(given, now);
    held_ = heard.held.pieces;
    return text(heard.held) + "|" + hex(heard.bytes);
  }
  std::string release() { return text(echo_->release()); }
  static std::string text(const bus::Echo::Held& held) {
    return hex({held.bytes.data(), held.bytes.size()});
  }
  void answered(std::string_view response, bool came_first = true) {
    echo_->note_answered(pdu(response), came_first);
  }
  std::vector<LineFault> told() {
    std::vector<LineFault> told;
    while (const auto fault = faults_.take()) {
      told.push_back(*fault);
    }
    return told;
  }
  static modbus::Pdu pdu(std::string_view bytes) { return *modbus::Pdu::from(unhex(bytes)); }

  bus::BusCounters counters_;
  bus::LineFaults faults_;
  std::optional<bus::Transaction> transaction_;
  std::optional<bus::Echo> echo_;
  bus::Echo::Pieces held_;
};

}  // namespace mbgate::test
