// SPDX-License-Identifier: Apache-2.0
// Requests and rules of the Autonics AiC's manual, sections 1 and 2; PDUs, because it prints no
// CRCs.
#include "sim/drives/aic_drive.hpp"

#include <gtest/gtest.h>

#include "unit/sim/drives/drive_rig.hpp"

namespace mbgate::test {
namespace {

using namespace std::chrono_literals;
using modbus::Table;

class AicModel : public testing::Test {
 protected:
  std::uint32_t input(std::uint16_t address) {
    return drive_.bank(Table::input_registers).get(address);
  }
  std::uint32_t holding(std::uint16_t address) {
    return drive_.bank(Table::holding_registers).get(address);
  }
  std::string answer(std::string_view request) { return answer_of(drive_, request); }

  sim::AicDrive drive_;
};

TEST_F(AicModel, PacksCoilsLikeThePrintedAnswer) {
  // 1.1: 000008 to 000001 are ON-ON-OFF-OFF-ON-ON-OFF-ON, 000010 and 000009 OFF-ON.
  for (const auto* const request : {"05 00 00 FF 00", "05 00 02 FF 00", "05 00 03 FF 00",
                                    "05 00 06 FF 00", "05 00 07 FF 00", "05 00 08 FF 00"}) {
    EXPECT_EQ(answer(request), request);
  }
  EXPECT_EQ(answer("01 00 00 00 0A"), "01 02 CD 01");
  EXPECT_EQ(answer("05 00 00 00 00"), "05 00 00 00 00");
  EXPECT_EQ(answer("01 00 00 00 0A"), "01 02 CC 01");
}

TEST_F(AicModel, ReadsInputs) {
  EXPECT_EQ(answer("02 00 00 00 0A"), "02 02 00 00");
  EXPECT_EQ(answer("02 00 1C 00 03"), "02 01 05");  // servo on, in position, no alarm
}

TEST_F(AicModel, TellsItsModelName) {
  EXPECT_EQ(answer("04 00 68 00 05"), "04 0A 41 69 43 2D 44 2D 35 36 4C 41");  // "AiC-D-56LA"
}

TEST_F(AicModel, MovesToThePositionToMove) {
  EXPECT_EQ(answer("10 00 08 00 02 04 00 03 0D 40"), "10 00 08 00 02");
  EXPECT_EQ(answer("05 00 11 FF 00"), "05 00 11 FF 00");
  EXPECT_EQ(answer("04 03 E8 00 04"), "04 08 00 03 0D 40 00 03 0D 40");
  EXPECT_EQ(answer("05 00 12 FF 00"), "05 00 12 FF 00");
  EXPECT_EQ(input(sim::kAicActualPosition), 400000U);
  EXPECT_EQ(answer("05 00 0E FF 00"), "05 00 0E FF 00");
  EXPECT_EQ(input(sim::kAicActualPosition), 0U);
  EXPECT_EQ(input(sim::kAicCommandPosition), 400000U);
}

TEST_F(AicModel, IgnoresACommandThatIsSwitchedOff) {
  answer("10 00 08 00 02 04 00 03 0D 40");
  EXPECT_EQ(answer("05 00 11 00 00"), "05 00 11 00 00");
  EXPECT_EQ(input(sim::kAicActualPosition), 0U);
}

TEST_F(AicModel, RunsUntilAnyStop) {
  for (const auto* const stop : {"05 00 0B FF 00", "05 00 16 FF 00", "05 00 17 FF 00"}) {
    EXPECT_EQ(answer("05 00 0F FF 00"), "05 00 0F FF 00");
    EXPECT_EQ(answer("04 03 E7 00 01"), "04 02 00 03");
    EXPECT_EQ(answer(stop), stop);
    EXPECT_EQ(answer("04 03 E7 00 01"), "04 02 00 00");
  }
  EXPECT_EQ(answer("04 03 F2 00 01"), "04 02 20 00");  // emergency stop error
  EXPECT_EQ(answer("02 00 1D 00 01"), "02 01 01");
  EXPECT_EQ(answer("05 00 0C FF 00"), "05 00 0C FF 00");
  EXPECT_EQ(answer("04 03 F2 00 01"), "04 02 00 00");
}

TEST_F(AicModel, ShowsItsSettingsAsCoilsAndAsRegisters) {
  EXPECT_EQ(answer("05 00 1E FF 00"), "05 00 1E FF 00");
  EXPECT_EQ(answer("05 00 3E FF 00"), "05 00 3E FF 00");
  EXPECT_EQ(answer("03 13 88 00 03"), "03 06 00 01 00 00 00 01");
  EXPECT_EQ(answer("06 13 89 00 04"), "06 13 89 00 04");
  EXPECT_EQ(answer("01 00 30 00 01"), "01 01 01");  // emergency stop logic
}

TEST_F(AicModel, RefusesToLeaveAParameterGroup) {
  EXPECT_EQ(answer("03 00 0B 00 01"), "03 02 00 00");
  EXPECT_EQ(answer("01 00 09 00 02"), "81 03");
  EXPECT_EQ(answer("03 00 31 00 02"), "83 03");
  EXPECT_EQ(answer("04 03 E6 00 02"), "84 03");
  EXPECT_EQ(answer("10 14 4F 00 02 04 00 00 00 00"), "90 03");
}

TEST_F(AicModel, HasNothingAtTheReservedPlacesOfItsGroups) {
  EXPECT_EQ(answer("03 00 0B 00 02"), "83 02");
  EXPECT_EQ(answer("04 00 7C 00 02"), "84 02");
  EXPECT_EQ(answer("01 00 41 00 01"), "01 01 00");
  EXPECT_EQ(answer("01 00 42 00 01"), "81 02");
  EXPECT_EQ(answer("10 14 53 00 02 04 00 14 00 00"), "90 02");
}

TEST_F(AicModel, AnswersAtMost123Registers) {
  EXPECT_EQ(drive_.answer(pdu_of("03 00 32 00 7B")).response->size(), 248U);
  EXPECT_EQ(answer("03 00 32 00 7C"), "83 03");
}

TEST_F(AicModel, AnswersExceptions) {
  EXPECT_EQ(answer("01 03 E8 00 01"), "81 02");  // 1.8
  EXPECT_EQ(answer("01 00 0B 00 01"), "81 02");  // a command is write only
  EXPECT_EQ(answer("0F 00 00 00 01 01 01"), "8F 01");
  EXPECT_EQ(answer("06 14 53 00 64"), "86 03");  // 100 ms is out of range
  EXPECT_EQ(answer("03 00 00 00 02"), "83 02");  // reserved
}

TEST_F(AicModel, HoldsItsAnswersBackAsItsRegisterSays) {
  EXPECT_EQ(drive_.answer(pdu_of("03 00 0A 00 01")).delay, 1ms);
  EXPECT_EQ(drive_.answer(pdu_of("06 14 53 00 14")).delay, 1ms);
  EXPECT_EQ(drive_.answer(pdu_of("03 00 0A 00 01")).delay, 20ms);
}

TEST_F(AicModel, HearsOnlyItsOwnBroadcastFunctions) {
  EXPECT_FALSE(drive_.hear_broadcast(pdu_of("86 14 53 00 14")).response);
  EXPECT_EQ(holding(sim::kAicResponseWait), 20U);
  EXPECT_FALSE(drive_.hear_broadcast(pdu_of("06 14 53 00 15")).response);
  EXPECT_EQ(holding(sim::kAicResponseWait), 20U);
  drive_.hear_broadcast(pdu_of("90 14 51 00 02 04 00 01 00 01"));
  EXPECT_EQ(holding(0x1451), 1U);
  EXPECT_EQ(holding(0x1452), 1U);
  answer("05 00 0F FF 00");
  drive_.hear_broadcast(pdu_of("85 00 17 FF 00"));
  EXPECT_EQ(input(sim::kAicRunMode), 0U);
}

TEST_F(AicModel, IgnoresBroadcastsOfWhatIsNotListed) {
  drive_.hear_broadcast(pdu_of("90 14 50 00 03 06 00 01 00 01 00 01"));  // more than two
  EXPECT_EQ(holding(0x1450), 0U);
  drive_.hear_broadcast(pdu_of("86 00 0A 00 05"));  // no communication register
  EXPECT_EQ(holding(0x000A), 0U);
  drive_.hear_broadcast(pdu_of("85 00 00 FF 00"));  // an output, no command
  EXPECT_EQ(drive_.bank(Table::coils).get(0), 0U);
}

}  // namespace
}  // namespace mbgate::test
