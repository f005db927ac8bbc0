// SPDX-License-Identifier: Apache-2.0
// What each client gets of a longer read.
#include "bus/sharing/shared_read.hpp"

#include <gtest/gtest.h>

#include "support/hex.hpp"

namespace mbgate::test {
namespace {

TEST(SharedRead, BitsAreTakenOutOfTheirBytes) {
  const auto whole = *modbus::Pdu::from(unhex("01 03 CD 6B 05"));  // 20 coils from 19 on
  const modbus::TableRange range{modbus::Table::coils, 19, 20};
  const auto part = [&](std::uint16_t first, std::uint16_t count) {
    return hex(bus::part_of(whole, range, {modbus::Table::coils, first, count}).bytes());
  };
  EXPECT_EQ(part(19, 20), "01 03 CD 6B 05");
  EXPECT_EQ(part(27, 8), "01 01 6B");
  EXPECT_EQ(part(20, 3), "01 01 06");
  EXPECT_EQ(part(26, 9), "01 02 D7 00");
}

}  // namespace
}  // namespace mbgate::test
