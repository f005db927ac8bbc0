// SPDX-License-Identifier: Apache-2.0
// Frames of MOONS' manual, sections 5, 7.1 and 7.4, without address and CRC.
#include "sim/drives/moons_drive.hpp"

#include <gtest/gtest.h>

#include "unit/sim/drives/drive_rig.hpp"

namespace mbgate::test::moons_drive_test {
namespace {

using drive::WordOrder;
using sim::MoonsDrive;
using sim::MoonsSeries;

constexpr auto kBigProfile = "10 00 1B 00 05 0A 02 58 02 58 00 F0 00 03 0D 40";
constexpr auto kLittleProfile = "10 00 1B 00 05 0A 02 58 02 58 00 F0 0D 40 00 03";

class MoonsModel : public testing::Test {
 protected:
  std::uint32_t position() { return big_.registers().get(sim::kMoonsPosition); }

  MoonsDrive big_{MoonsSeries::st, WordOrder::big};
  MoonsDrive little_{MoonsSeries::st, WordOrder::little};
  MoonsDrive servo_{MoonsSeries::m2, WordOrder::big};
};

TEST_F(MoonsModel, IsEnabledAndInPositionAtFirst) {
  EXPECT_EQ(answer_of(big_, "03 00 01 00 01"), "03 02 00 09");
}

TEST_F(MoonsModel, TakesThePositionProfileInEitherWordOrder) {
  EXPECT_EQ(answer_of(big_, kBigProfile), "10 00 1B 00 05");
  EXPECT_EQ(answer_of(little_, kLittleProfile), "10 00 1B 00 05");
  EXPECT_EQ(big_.registers().get(sim::kMoonsDistance), 200000U);
  EXPECT_EQ(little_.registers().get(sim::kMoonsDistance), 200000U);
  EXPECT_EQ(answer_of(big_, "03 00 1B 00 05"), "03 0A 02 58 02 58 00 F0 00 03 0D 40");
  EXPECT_EQ(answer_of(little_, "03 00 1B 00 05"), "03 0A 02 58 02 58 00 F0 0D 40 00 03");
}

TEST_F(MoonsModel, KeepsUserRegistersAsValues) {
  const auto* const big = "10 00 3C 00 06 0C 00 00 00 00 00 00 00 0B 00 00 00 0C";
  const auto* const little = "10 00 3C 00 06 0C 00 00 00 00 00 0B 00 00 00 0C 00 00";
  EXPECT_EQ(answer_of(big_, big), "10 00 3C 00 06");
  EXPECT_EQ(answer_of(little_, little), "10 00 3C 00 06");
  EXPECT_EQ(answer_of(big_, "03 00 3C 00 06"), "03 0C 00 00 00 00 00 00 00 0B 00 00 00 0C");
  EXPECT_EQ(answer_of(little_, "03 00 3C 00 06"), "03 0C 00 00 00 00 00 0B 00 00 00 0C 00 00");
}

TEST_F(MoonsModel, FeedsToPositionAndToLength) {
  answer_of(big_, kBigProfile);
  EXPECT_EQ(answer_of(big_, "06 00 7C 00 67"), "06 00 7C 00 67");
  EXPECT_EQ(position(), 200000U);
  EXPECT_EQ(answer_of(big_, "06 00 7C 00 67"), "06 00 7C 00 67");
  EXPECT_EQ(position(), 200000U);
  EXPECT_EQ(answer_of(big_, "06 00 7C 00 66"), "06 00 7C 00 66");
  EXPECT_EQ(position(), 400000U);
}

TEST_F(MoonsModel, JogsUntilAnyStop) {
  for (const auto* const stop : {"06 00 7C 00 E1", "06 00 7C 00 E2", "06 00 7C 00 D8"}) {
    EXPECT_EQ(answer_of(big_, "06 00 7C 00 96"), "06 00 7C 00 96");
    EXPECT_EQ(answer_of(big_, "03 00 01 00 01"), "03 02 00 31");
    EXPECT_EQ(answer_of(big_, "03 00 0A 00 02"), "03 04 00 F0 00 F0");
    EXPECT_EQ(answer_of(big_, stop), stop);
    EXPECT_EQ(answer_of(big_, "03 00 01 00 01"), "03 02 00 09");
    EXPECT_EQ(answer_of(big_, "03 00 0A 00 02"), "03 04 00 00 00 00");
  }
}

TEST_F(MoonsModel, TakesAnOpcodeTogetherWithItsParameters) {
  big_.registers().set(sim::kMoonsPosition, 5);
  EXPECT_EQ(answer_of(big_, "10 00 7C 00 02 04 00 DB 00 01"), "10 00 7C 00 02");  // 7.3: find home
  EXPECT_EQ(position(), 0U);
}

TEST_F(MoonsModel, AnswersItsOwnExceptions) {
  EXPECT_EQ(answer_of(big_, "01 04 A1 00 01"), "81 01");  // Appendix 2
  EXPECT_EQ(answer_of(big_, "04 00 00 00 01"), "84 01");
  EXPECT_EQ(answer_of(big_, "03 00 82 00 01"), "83 02");                 // beyond the map
  EXPECT_EQ(answer_of(big_, "03 00 7C 00 07"), "83 02");                 // reaching beyond it
  EXPECT_EQ(answer_of(big_, "03 00 00 00 33"), "83 03");                 // 51 registers
  EXPECT_EQ(answer_of(big_, "03 00 00 00 00"), "83 03");                 // none
  EXPECT_EQ(answer_of(servo_, "03 00 08 00 02"), "83 11");               // 40009: write only
  EXPECT_EQ(answer_of(big_, "06 00 01 00 00"), "86 12");                 // 40002: read only
  EXPECT_EQ(answer_of(big_, "10 00 08 00 02 04 00 00 00 00"), "90 12");  // ST: read only
  EXPECT_EQ(answer_of(servo_, "10 00 08 00 02 04 00 00 00 00"), "10 00 08 00 02");
  EXPECT_EQ(answer_of(big_, "06 00 1D 00 00"), "86 13");  // velocity 0
  EXPECT_EQ(answer_of(big_, "06 00 7C 00 01"), "86 13");  // no such opcode
}

TEST_F(MoonsModel, AnswersFiftyRegisters) {
  const auto response = *big_.answer(pdu_of("03 00 00 00 32")).response;
  EXPECT_EQ(response.size(), 102U);
  EXPECT_EQ(hex(response.bytes().first(6)), "03 64 00 00 00 09");
}

TEST_F(MoonsModel, HearsBroadcastWritesOnly) {
  EXPECT_FALSE(big_.hear_broadcast(pdu_of(kBigProfile)).response);
  EXPECT_EQ(big_.registers().get(sim::kMoonsDistance), 200000U);
  EXPECT_FALSE(big_.hear_broadcast(pdu_of("03 00 01 00 01")).response);
}

TEST_F(MoonsModel, ChangesItsWordOrderWithItsProtocolRegister) {
  servo_.registers().set(sim::kMoonsPosition, 200000);
  EXPECT_EQ(answer_of(servo_, "03 00 06 00 02"), "03 04 00 03 0D 40");
  EXPECT_EQ(answer_of(servo_, "06 00 B0 00 85"), "06 00 B0 00 85");  // PR=133
  EXPECT_EQ(answer_of(servo_, "03 00 06 00 02"), "03 04 0D 40 00 03");
}

}  // namespace
}  // namespace mbgate::test::moons_drive_test
