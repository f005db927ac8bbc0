// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <vector>

#include "ctl/request/value_text.hpp"

namespace mbgate::ctl {
namespace {

using drive::WordOrder;

TEST(Value, TakesItsRegistersInEitherOrder) {
  const std::vector<std::uint64_t> values{0x00030D40, 0xFFFFFFFB};
  const std::vector<std::uint16_t> big{0x0003, 0x0D40, 0xFFFF, 0xFFFB};
  const std::vector<std::uint16_t> little{0x0D40, 0x0003, 0xFFFB, 0xFFFF};
  EXPECT_EQ(to_registers(ValueType::i32, WordOrder::big, values), big);
  EXPECT_EQ(to_registers(ValueType::i32, WordOrder::little, values), little);
  EXPECT_EQ(to_values(ValueType::i32, WordOrder::big, big), values);
  EXPECT_EQ(to_values(ValueType::i32, WordOrder::little, little), values);
}

TEST(Value, Of64BitsIsMirroredWordByWord) {
  const std::vector<std::uint64_t> values{0x0123'4567'89AB'CDEF, 0xFFFF'FFFF'FFFF'FFFE};
  const std::vector<std::uint16_t> big{0x0123, 0x4567, 0x89AB, 0xCDEF,
                                       0xFFFF, 0xFFFF, 0xFFFF, 0xFFFE};
  const std::vector<std::uint16_t> little{0xCDEF, 0x89AB, 0x4567, 0x0123,
                                          0xFFFE, 0xFFFF, 0xFFFF, 0xFFFF};
  for (const auto type : {ValueType::u64, ValueType::i64, ValueType::f64}) {
    EXPECT_EQ(to_registers(type, WordOrder::big, values), big);
    EXPECT_EQ(to_registers(type, WordOrder::little, values), little);
    EXPECT_EQ(to_values(type, WordOrder::big, big), values);
    EXPECT_EQ(to_values(type, WordOrder::little, little), values);
  }
}

TEST(Value, OfOneRegisterKnowsNoOrder) {
  const std::vector<std::uint64_t> values{1, 0xFFFE};
  const std::vector<std::uint16_t> registers{1, 0xFFFE};
  for (const auto order : {WordOrder::big, WordOrder::little}) {
    EXPECT_EQ(to_registers(ValueType::u16, order, values), registers);
    EXPECT_EQ(to_values(ValueType::u16, order, registers), values);
  }
}

}  // namespace
}  // namespace mbgate::ctl
