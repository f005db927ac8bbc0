// SPDX-License-Identifier: Apache-2.0
#include "bus/transmission/read_cache.hpp"

#include <gtest/gtest.h>

#include "modbus/request.hpp"
#include "support/hex.hpp"

namespace mbgate::test {
namespace {

using namespace std::chrono_literals;

modbus::Request request(std::string_view pdu) {
  return *modbus::Request::parse(*modbus::Pdu::from(unhex(pdu)));
}

drive::Transaction read_at(std::size_t address, std::string_view response = "03 02 12 34") {
  drive::Transaction asked(1, modbus::make_read({modbus::Table::holding_registers,
                                                 static_cast<std::uint16_t>(address), 1}));
  asked.response = modbus::Pdu::from(unhex(response));
  return asked;
}

TEST(ReadCache, TheOldestOfManyMakesRoomForANewOne) {
  bus::ReadCache cache;
  for (std::size_t address = 0; address <= bus::kMostCachedReads; ++address) {
    cache.put(read_at(address), bus::Instant{} + 1ms * address, 0);
  }
  EXPECT_EQ(cache.find(read_at(0), bus::Instant{}), nullptr);
  EXPECT_NE(cache.find(read_at(1), bus::Instant{}), nullptr);
  EXPECT_NE(cache.find(read_at(bus::kMostCachedReads), bus::Instant{}), nullptr);
}

TEST(ReadCache, ANewerResponseTakesThePlaceOfTheOneBefore) {
  bus::ReadCache cache;
  cache.put(read_at(0), bus::Instant{}, 0);
  const auto newer = read_at(0, "03 02 00 01");
  cache.put(newer, bus::Instant{} + 1s, 0);
  const modbus::Pdu* found = cache.find(read_at(0), bus::Instant{} + 1s);
  ASSERT_NE(found, nullptr);
  EXPECT_EQ(*found, newer.response);
}

TEST(ReadCache, HoldsBitsAndRegistersAlone) {
  for (const auto* held : {"01 0000 0001", "02 0000 0001", "03 0000 0001", "04 0000 0001"}) {
    EXPECT_TRUE(bus::ReadCache::can_hold(request(held))) << held;
  }
  for (const auto* other : {"05 0000 FF00", "07", "18 0000"}) {
    EXPECT_FALSE(bus::ReadCache::can_hold(request(other))) << other;
  }
}

// A gateway with drives behind it, which the configuration takes for one device.
TEST(ReadCache, DoesNotAnswerForAnotherUnit) {
  bus::ReadCache cache;
  cache.put(read_at(0), bus::Instant{}, 0);
  auto other = read_at(0);
  other.unit = 2;
  EXPECT_EQ(cache.find(other, bus::Instant{}), nullptr);
}

}  // namespace
}  // namespace mbgate::test
