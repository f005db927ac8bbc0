// SPDX-License-Identifier: Apache-2.0
// Which writes stop a drive and do nothing else.
#include <gtest/gtest.h>

#include <array>

#include "drive/device.hpp"
#include "modbus/request.hpp"

namespace mbgate::drive {
namespace {

using modbus::Request;
using modbus::Table;

constexpr std::uint16_t kCoilOn = 0xFF00;

// The stepper's: bit 0 of the jog and of torque mode; an opcode with five parameters; a coil.
Device drive_with_stops() {
  constexpr std::uint16_t kBit0 = 0x0001;
  constexpr std::uint16_t kWhole = 0xFFFF;
  Device device;
  device.profile.stops = {{Table::holding_registers, 0xCA, kBit0, 0},
                          {Table::holding_registers, 0xCB, kBit0, 0},
                          {Table::holding_registers, 0x7C, kWhole, 0xE1, false, 5},
                          {Table::holding_registers, 0xFFFF, kWhole, 0},
                          {Table::coils, 4, kWhole, kCoilOn},
                          {Table::coils, 5, kWhole, 0}};
  return device;
}

Request registers(std::uint16_t first, std::initializer_list<std::uint16_t> values) {
  std::vector<std::uint8_t> bytes;
  for (const std::uint16_t value : values) {
    bytes.push_back(static_cast<std::uint8_t>(value >> 8U));
    bytes.push_back(static_cast<std::uint8_t>(value & 0xFFU));
  }
  const auto count = static_cast<std::uint16_t>(values.size());
  return modbus::make_multiple_write({Table::holding_registers, first, count}, bytes);
}

Request coils(std::uint16_t first, std::uint16_t count, std::uint8_t bits) {
  return modbus::make_multiple_write({Table::coils, first, count}, std::array{bits});
}

bool stops(const Request& request) { return drive_with_stops().is_stop(request); }

TEST(Stop, IsAWriteOfOneValueThatStops) {
  EXPECT_TRUE(stops(modbus::make_single_write(Table::holding_registers, 0xCA, 0)));
  EXPECT_TRUE(stops(modbus::make_single_write(Table::holding_registers, 0xCA, 2)));
  EXPECT_FALSE(stops(modbus::make_single_write(Table::holding_registers, 0xCA, 1)));
  EXPECT_TRUE(stops(modbus::make_single_write(Table::coils, 4, kCoilOn)));
  EXPECT_FALSE(stops(modbus::make_single_write(Table::coils, 4, 0)));
  EXPECT_TRUE(stops(registers(0xFFFF, {0})));
}

TEST(Stop, IsAWriteOfSeveralValuesIfEachOfThemStops) {
  EXPECT_TRUE(stops(registers(0xCA, {0, 0})));
  EXPECT_FALSE(stops(registers(0xCA, {1, 0})));
  EXPECT_FALSE(stops(registers(0xCA, {0, 1})));
  EXPECT_FALSE(stops(registers(0xC9, {0, 0})));
  EXPECT_FALSE(stops(registers(0xCA, {0, 0, 0})));
  EXPECT_TRUE(stops(coils(4, 2, 0b01)));
  EXPECT_FALSE(stops(coils(4, 2, 0b11)));
}

TEST(Stop, MayHaveItsOwnParametersBehindIt) {
  EXPECT_TRUE(stops(registers(0x7C, {0xE1, 1, 2, 3, 4, 5})));
  EXPECT_FALSE(stops(registers(0x7C, {0xE1, 1, 2, 3, 4, 5, 6})));
  EXPECT_FALSE(stops(registers(0x7C, {0xE2, 1, 2})));
  EXPECT_FALSE(stops(registers(0x7D, {1, 2, 3, 4, 5})));  // the parameters alone
}

TEST(Stop, OfTwoEntriesThatFitHasTheParametersOfTheLongerOne) {
  Device device = drive_with_stops();  // the user's own entry stands behind that of the profile
  device.profile.stops.push_back({Table::holding_registers, 0xCB, 0xFFFF, 0, false, 2});
  EXPECT_TRUE(device.is_stop(registers(0xCB, {0, 7, 8})));
  EXPECT_TRUE(device.is_stop(registers(0xCB, {2})));
  EXPECT_FALSE(device.is_stop(registers(0xCB, {2, 7, 8})));
}

TEST(Stop, IsNoOtherFunction) {
  const auto mask_write =
      modbus::Pdu::from(std::array<std::uint8_t, 7>{0x16, 0x00, 0xCA, 0xFF, 0xFE, 0x00, 0x00});
  EXPECT_FALSE(stops(*Request::parse(*mask_write)));
  EXPECT_FALSE(stops(modbus::make_read_write({Table::holding_registers, 0, 1},
                                             {Table::holding_registers, 0xCA, 1},
                                             std::array<std::uint8_t, 2>{})));
  EXPECT_FALSE(stops(modbus::make_read({Table::holding_registers, 0xCA, 1})));
}

}  // namespace
}  // namespace mbgate::drive
