// SPDX-License-Identifier: Apache-2.0
// The result of one read of a scan.
#pragma once

#include <chrono>
#include <cstdint>
#include <vector>

#include "modbus/request.hpp"

namespace mbgate::ctl {

enum class AnswerKind : std::uint8_t {
  data,
  exception,
  busy,    ///< an exception that says nothing about the device: try again later
  no_way,  ///< the gateway did not transmit it
  silence
};

struct Answer {
  AnswerKind kind = AnswerKind::silence;
  std::uint8_t exception = 0;
  std::vector<std::uint16_t> registers{};  ///< of `data`; bits as 0 and 1
  std::chrono::nanoseconds took{0};
};

/// The function that reads the table.
constexpr std::uint8_t read_function(modbus::Table table) {
  switch (table) {
    case modbus::Table::coils: return 0x01;
    case modbus::Table::discrete_inputs: return 0x02;
    case modbus::Table::holding_registers: return 0x03;
    case modbus::Table::input_registers: return 0x04;
  }
  return 0x03;
}

}  // namespace mbgate::ctl
