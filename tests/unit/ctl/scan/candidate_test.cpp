// SPDX-License-Identifier: Apache-2.0
#include "ctl/scan/candidate.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mbgate::ctl {
namespace {

using modbus::Table;
using modbus::TableRange;
using testing::Contains;
using testing::Not;

constexpr auto kHolding = Table::holding_registers;
constexpr auto kInput = Table::input_registers;

config::ProfileFile made_up() {
  const auto loaded = config::load_profile(config::TextFile{"drive.toml", R"(
name = "drive"
description = "A drive"
manual = "Manual"
section = "1"
lines = "1-2"
functions = [3, 4, 6]
word_order = "settable"
map = [
  { register = 10, registers = 10, line = 1 },
  { register = 20, registers = 10, line = 1 },
  { register = 50, registers = 2, line = 1 },
]
groups = [
  { register = 10, registers = 5, line = 1 },
  { register = 15, registers = 25, line = 1 },
]
strings = [ { register = 12, registers = 2, name = "model", line = 1 } ]
write_only = [ { register = 29, name = "command", line = 1 } ]
[limits]
read_holding = 8
[word_order_register]
register = 16
big = [5]
little = [133]
line = 1
)"});
  EXPECT_EQ(config::render(loaded.diagnostics), "");
  return *loaded.file;
}

Answer data(std::vector<std::uint16_t> registers) {
  return {AnswerKind::data, 0, std::move(registers)};
}
Answer exception(std::uint8_t code) { return {AnswerKind::exception, code}; }

class ACandidate : public testing::Test {
 protected:
  config::ProfileFile file_ = made_up();
  Candidate candidate_{file_};
};

TEST_F(ACandidate, ForeseesDataWhereTheMapHasRegisters) {
  EXPECT_EQ(candidate_.foresees({kHolding, 10, 1}), Foreseen::data);
  EXPECT_EQ(candidate_.foresees({kHolding, 18, 5}), Foreseen::data);
  EXPECT_EQ(candidate_.foresees({kHolding, 50, 2}), Foreseen::data);
}

TEST_F(ACandidate, ForeseesARefusalOutsideTheMap) {
  EXPECT_EQ(candidate_.foresees({kHolding, 9, 1}), Foreseen::refusal);
  EXPECT_EQ(candidate_.foresees({kHolding, 51, 2}), Foreseen::refusal);
}

TEST_F(ACandidate, KnowsNothingOfTheReserveOfAGroupNorOfATableWithoutMap) {
  EXPECT_EQ(candidate_.foresees({kHolding, 30, 1}), Foreseen::anything);
  EXPECT_EQ(candidate_.foresees({kInput, 10, 1}), Foreseen::anything);
}

TEST_F(ACandidate, ForeseesARefusalOfTooManyWriteOnlyAndCrossedGroups) {
  EXPECT_EQ(candidate_.foresees({kHolding, 15, 9}), Foreseen::refusal);
  EXPECT_EQ(candidate_.foresees({kHolding, 28, 2}), Foreseen::refusal);
  EXPECT_EQ(candidate_.foresees({kHolding, 14, 2}), Foreseen::refusal);
}

TEST_F(ACandidate, ForeseesTextsWordOrdersAndFunctionsItLacks) {
  EXPECT_EQ(candidate_.foresees({kHolding, 12, 2}), Foreseen::text);
  EXPECT_EQ(candidate_.foresees({kHolding, 16, 1}), Foreseen::word_order);
  EXPECT_EQ(candidate_.foresees({Table::coils, 0, 1}), Foreseen::no_function);
}

TEST_F(ACandidate, ReadsHoldingRegistersAsInputsWhereTheyAreTheSame) {
  file_.profile.input_as_holding = true;
  const Candidate candidate(file_);
  EXPECT_EQ(candidate.foresees({kInput, 10, 1}), Foreseen::data);
  EXPECT_EQ(candidate.foresees({kInput, 52, 1}), Foreseen::refusal);
}

TEST_F(ACandidate, JudgesDataByWhatIsForeseen) {
  EXPECT_EQ(candidate_.judge({kHolding, 10, 1}, data({0})), Verdict::fits);
  EXPECT_EQ(candidate_.judge({kHolding, 52, 1}, data({0})), Verdict::contradicts);
  EXPECT_EQ(candidate_.judge({Table::coils, 0, 1}, data({0})), Verdict::contradicts);
  EXPECT_EQ(candidate_.judge({kHolding, 30, 1}, data({0})), Verdict::open);
}

TEST_F(ACandidate, JudgesWordOrdersAndTextsByTheirContent) {
  EXPECT_EQ(candidate_.judge({kHolding, 16, 1}, data({5})), Verdict::fits);
  EXPECT_EQ(candidate_.judge({kHolding, 16, 1}, data({133})), Verdict::fits);
  EXPECT_EQ(candidate_.judge({kHolding, 16, 1}, data({0})), Verdict::contradicts);
  EXPECT_EQ(candidate_.judge({kHolding, 12, 2}, data({0x4D32, 0x0000})), Verdict::fits);
  EXPECT_EQ(candidate_.judge({kHolding, 12, 2}, data({0x0001, 0x4D32})), Verdict::contradicts);
  EXPECT_EQ(candidate_.judge({kHolding, 12, 2}, data({0, 0})), Verdict::open);
}

TEST_F(ACandidate, TellsARefusedFunctionFromARefusedPlace) {
  const TableRange place{kHolding, 52, 1};
  const TableRange function{Table::coils, 0, 1};
  EXPECT_EQ(candidate_.judge(place, exception(0x02)), Verdict::fits);
  EXPECT_EQ(candidate_.judge(place, exception(0x11)), Verdict::fits);
  EXPECT_EQ(candidate_.judge(place, exception(0x01)), Verdict::contradicts);
  EXPECT_EQ(candidate_.judge(function, exception(0x01)), Verdict::fits);
  EXPECT_EQ(candidate_.judge(function, exception(0x02)), Verdict::open);
  EXPECT_EQ(candidate_.judge({kHolding, 10, 1}, exception(0x02)), Verdict::contradicts);
}

TEST_F(ACandidate, TakesSilenceForNoDataButNotForARefusal) {
  EXPECT_EQ(candidate_.judge({kHolding, 10, 1}, {AnswerKind::silence}), Verdict::contradicts);
  EXPECT_EQ(candidate_.judge({kHolding, 52, 1}, {AnswerKind::silence}), Verdict::open);
  EXPECT_EQ(candidate_.judge({Table::coils, 0, 1}, {AnswerKind::silence}), Verdict::open);
  EXPECT_EQ(candidate_.judge({kHolding, 10, 1}, {AnswerKind::busy, 0x06}), Verdict::open);
}

TEST_F(ACandidate, IsToldByTheBordersOfItsMapWhereNeighboursAreOne) {
  const auto reads = candidate_.telling_reads();
  EXPECT_THAT(reads, Contains(TableRange{kHolding, 10, 1}));
  EXPECT_THAT(reads, Contains(TableRange{kHolding, 29, 1}));
  EXPECT_THAT(reads, Contains(TableRange{kHolding, 52, 1}));
  EXPECT_THAT(reads, Contains(TableRange{kHolding, 10, 9}));
  EXPECT_THAT(reads, Not(Contains(TableRange{kHolding, 20, 1})));
}

TEST_F(ACandidate, IsConfirmedByItsContentsTheEndOfItsLongestRunAndItsLimit) {
  EXPECT_THAT(candidate_.confirming_reads(),
              testing::ElementsAre(TableRange{kHolding, 12, 2}, TableRange{kHolding, 16, 1},
                                   TableRange{kHolding, 29, 1}, TableRange{kHolding, 10, 9}));
}

TEST(RegisterText, HasTheLowByteFirstWhereTheLowWordIs) {
  EXPECT_EQ(register_text({0x3731, 0x0030}, drive::WordOrder::little), "170");
  EXPECT_EQ(register_text({0x4169, 0x4320}, drive::WordOrder::big), "AiC");
  EXPECT_EQ(register_text({0x0000, 0x2020}, drive::WordOrder::big), "");
  EXPECT_EQ(register_text({0x4101}, drive::WordOrder::big), "");
}

}  // namespace
}  // namespace mbgate::ctl
