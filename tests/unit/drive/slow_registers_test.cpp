// SPDX-License-Identifier: Apache-2.0
// Registers that a drive takes longer for.
#include <gtest/gtest.h>

#include "drive/device.hpp"
#include "modbus/request.hpp"

namespace mbgate::drive {
namespace {

using namespace std::chrono_literals;
using modbus::Table;

TEST(SlowRegisters, AreSlowByFunction04TooIfItReadsTheSame) {
  Device device;
  device.timing.response_timeout = 300ms;
  device.profile.slow = {{{Table::holding_registers, 220, 1}, 3s}};
  const auto timeout = [&](Table table, std::uint16_t first) {
    return device.timing_of(modbus::make_read({table, first, 1})).response_timeout;
  };
  EXPECT_EQ(timeout(Table::holding_registers, 220), 3s);
  EXPECT_EQ(timeout(Table::holding_registers, 221), 300ms);
  EXPECT_EQ(timeout(Table::input_registers, 220), 300ms);
  device.profile.input_as_holding = true;
  EXPECT_EQ(timeout(Table::input_registers, 220), 3s);
  EXPECT_EQ(timeout(Table::input_registers, 221), 300ms);
}

}  // namespace
}  // namespace mbgate::drive
