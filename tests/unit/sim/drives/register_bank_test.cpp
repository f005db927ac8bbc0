// SPDX-License-Identifier: Apache-2.0
#include "sim/drives/register_bank.hpp"

#include <gmock/gmock.h>

#include <array>

namespace mbgate::test {
namespace {

using drive::WordOrder;
using sim::Access;
using sim::Limits;
using sim::Refusal;
using sim::RegisterBank;
using sim::RegisterRun;
using sim::Width;
using testing::ElementsAre;

constexpr std::array kMap{RegisterRun{10, 2, Width::word, Access::read_only, 7},
                          RegisterRun{12, 2, Width::value, Access::read_write, 0x00030D40},
                          RegisterRun{16, 1, Width::word, Access::write_only, 5},
                          RegisterRun{20, 1, Width::word, Access::read_write, 0, Limits{-2, 2}}};

TEST(RegisterBank, PresentsValuesInItsWordOrder) {
  EXPECT_THAT(*RegisterBank(kMap, WordOrder::big).read(11, 3), ElementsAre(7, 0x0003, 0x0D40));
  EXPECT_THAT(*RegisterBank(kMap, WordOrder::little).read(11, 3), ElementsAre(7, 0x0D40, 0x0003));
}

TEST(RegisterBank, ReadsAndWritesHalfAValue) {
  RegisterBank bank(kMap, WordOrder::little);
  EXPECT_THAT(*bank.read(13, 2), ElementsAre(0x0003, 0x0D40));
  EXPECT_EQ(bank.write(13, std::array<std::uint16_t, 1>{0xFFFF}), std::nullopt);
  EXPECT_EQ(bank.get(12), 0xFFFF0D40U);
  EXPECT_EQ(bank.get(13), 0xFFFF0D40U);
  EXPECT_EQ(bank.get(14), 0x00030D40U);
}

TEST(RegisterBank, RefusesWhatTheRightsForbid) {
  RegisterBank bank(kMap, WordOrder::big);
  EXPECT_EQ(bank.read(9, 2).error(), Refusal::no_such_register);
  EXPECT_EQ(bank.read(15, 2).error(), Refusal::not_readable);
  EXPECT_EQ(bank.read(65535, 1).error(), Refusal::no_such_register);
  EXPECT_EQ(bank.write(11, std::array<std::uint16_t, 1>{1}), Refusal::not_writable);
  EXPECT_EQ(bank.write(16, std::array<std::uint16_t, 2>{1, 2}), Refusal::no_such_register);
}

TEST(RegisterBank, WritesAllOrNothing) {
  RegisterBank bank(kMap, WordOrder::big);
  EXPECT_EQ(bank.write(15, std::array<std::uint16_t, 3>{1, 2, 3}), Refusal::no_such_register);
  EXPECT_EQ(bank.get(14), 0x00030D40U);
  EXPECT_EQ(bank.get(16), 5U);
}

TEST(RegisterBank, HoldsSignedLimits) {
  RegisterBank bank(kMap, WordOrder::big);
  EXPECT_EQ(bank.write(20, std::array<std::uint16_t, 1>{0xFFFE}), std::nullopt);
  EXPECT_EQ(bank.write(20, std::array<std::uint16_t, 1>{3}), Refusal::out_of_range);
  EXPECT_EQ(bank.write(20, std::array<std::uint16_t, 1>{0x8000}), Refusal::out_of_range);
  EXPECT_EQ(bank.get(20), 0xFFFEU);
}

TEST(RegisterBank, RestoresInitialValues) {
  RegisterBank bank(kMap, WordOrder::big);
  bank.set(12, 1);
  bank.set(10, 0x12345);
  EXPECT_EQ(bank.get(10), 0x2345U);
  bank.restore_initial();
  EXPECT_EQ(bank.get(10), 7U);
  EXPECT_EQ(bank.get(12), 0x00030D40U);
}

}  // namespace
}  // namespace mbgate::test
