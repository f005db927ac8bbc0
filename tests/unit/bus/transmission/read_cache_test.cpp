// SPDX-License-Identifier: Apache-2.0
#include "bus/transmission/read_cache.hpp"

#include <gtest/gtest.h>

#include "modbus/request.hpp"
#include "support/hex.hpp"

namespace mbgate::test {
namespace {

using namespace std::chrono_literals;

modbus::Request read_at(std::size_t address) {
  return modbus::make_read(
      {modbus::Table::holding_registers, static_cast<std::uint16_t>(address), 1});
}

TEST(ReadCache, TheOldestOfManyMakesRoomForANewOne) {
  const auto response = *modbus::Pdu::from(unhex("03 02 12 34"));
  bus::ReadCache cache;
  for (std::size_t address = 0; address <= bus::kMostCachedReads; ++address) {
    cache.put(read_at(address), response, bus::Instant{} + 1ms * address, 0);
  }
  EXPECT_EQ(cache.find(read_at(0), bus::Instant{}), nullptr);
  EXPECT_NE(cache.find(read_at(1), bus::Instant{}), nullptr);
  EXPECT_NE(cache.find(read_at(bus::kMostCachedReads), bus::Instant{}), nullptr);
}

TEST(ReadCache, ANewerResponseTakesThePlaceOfTheOneBefore) {
  bus::ReadCache cache;
  cache.put(read_at(0), *modbus::Pdu::from(unhex("03 02 12 34")), bus::Instant{}, 0);
  const auto newer = *modbus::Pdu::from(unhex("03 02 00 01"));
  cache.put(read_at(0), newer, bus::Instant{} + 1s, 0);
  const modbus::Pdu* found = cache.find(read_at(0), bus::Instant{} + 1s);
  ASSERT_NE(found, nullptr);
  EXPECT_EQ(*found, newer);
}

}  // namespace
}  // namespace mbgate::test
