// SPDX-License-Identifier: Apache-2.0
// Frames of the RS-485 stepper's manual, section VIII, without address and CRC.
#include "sim/drives/stepper_drive.hpp"

#include <gtest/gtest.h>

#include <map>

#include "manuals/vectors.hpp"
#include "modbus/frames.hpp"
#include "unit/sim/drives/drive_rig.hpp"

namespace mbgate::test::stepper_drive_test {
namespace {

using namespace std::chrono_literals;

class StepperModel : public testing::Test {
 protected:
  std::uint32_t position() { return drive_.registers().get(sim::kStepperPosition); }
  std::string echo(std::string_view request) { return answer_of(drive_, request); }

  sim::StepperDrive drive_;
};

TEST_F(StepperModel, TellsItsVersionsLowByteFirst) {
  EXPECT_EQ(answer_of(drive_, "03 00 00 00 02"), "03 04 37 31 00 30");
  EXPECT_EQ(answer_of(drive_, "03 00 02 00 02"), "03 04 30 31 00 35");
}

TEST_F(StepperModel, HasTheFactoryValuesThatThePrintedAnswersShow) {
  EXPECT_EQ(answer_of(drive_, "03 00 04 00 02"), "03 04 00 00 00 00");
  EXPECT_EQ(answer_of(drive_, "03 00 09 00 01"), "03 02 00 0C");
  EXPECT_EQ(answer_of(drive_, "03 00 0A 00 01"), "03 02 00 FA");
  EXPECT_EQ(answer_of(drive_, "03 00 D8 00 02"), "03 04 75 30 00 00");
}

TEST_F(StepperModel, WritesAValueLowWordFirst) {
  EXPECT_EQ(echo("10 00 D8 00 02 04 C3 50 00 00"), "10 00 D8 00 02");
  EXPECT_EQ(drive_.registers().get(sim::kStepperSpeed), 50000U);
}

TEST_F(StepperModel, MovesWhereTheMotionValuesSay) {
  EXPECT_EQ(echo("10 00 D0 00 02 04 27 10 00 00"), "10 00 D0 00 02");
  EXPECT_EQ(position(), 10000U);
  EXPECT_EQ(echo("10 00 CE 00 02 04 D8 F0 FF FF"), "10 00 CE 00 02");
  EXPECT_EQ(position(), 0U);
  EXPECT_EQ(echo("10 00 DE 00 02 04 13 88 00 00"), "10 00 DE 00 02");
  EXPECT_EQ(position(), 5000U);
  EXPECT_EQ(echo("10 00 E8 00 02 04 E0 C0 FF FF"), "10 00 E8 00 02");
  EXPECT_EQ(static_cast<std::int32_t>(position()), -8000);
  EXPECT_EQ(answer_of(drive_, "03 00 04 00 02"), "03 04 E0 C0 FF FF");
  EXPECT_EQ(echo("10 00 D2 00 02 04 03 E8 00 00"), "10 00 D2 00 02");
  EXPECT_EQ(position(), 1000U);
}

TEST_F(StepperModel, RunsForADurationAtItsSpeed) {
  // 6.4 s backwards at 300 turns a minute and 4000 pulses a turn.
  EXPECT_EQ(echo("10 00 CC 00 02 04 E7 00 FF FF"), "10 00 CC 00 02");
  EXPECT_EQ(static_cast<std::int32_t>(position()), -128000);
}

TEST_F(StepperModel, RunsUntilItIsStopped) {
  EXPECT_EQ(echo("06 00 C8 01 01"), "06 00 C8 01 01");
  EXPECT_EQ(answer_of(drive_, "03 00 06 00 02"), "03 04 03 00 00 00");
  EXPECT_EQ(echo("06 00 C8 01 00"), "06 00 C8 01 00");
  EXPECT_EQ(answer_of(drive_, "03 00 06 00 02"), "03 04 10 00 00 00");
  EXPECT_EQ(echo("06 00 CA 0C 81"), "06 00 CA 0C 81");
  EXPECT_EQ(answer_of(drive_, "03 00 06 00 02"), "03 04 03 00 00 00");
  EXPECT_EQ(echo("06 00 CA 00 00"), "06 00 CA 00 00");
  EXPECT_EQ(answer_of(drive_, "03 00 06 00 02"), "03 04 10 00 00 00");
}

TEST_F(StepperModel, NeverAnswersARestart) {
  drive_.registers().set(sim::kStepperPosition, 77);
  const auto reaction = drive_.answer(pdu_of("06 00 D4 01 00"));
  EXPECT_FALSE(reaction.response);
  EXPECT_EQ(reaction.deaf_for, 500ms);
  EXPECT_EQ(position(), 0U);
}

TEST_F(StepperModel, AnswersEnableAndRelease) {
  EXPECT_EQ(echo("06 00 D4 00 00"), "06 00 D4 00 00");
  EXPECT_EQ(echo("06 00 D4 00 01"), "06 00 D4 00 01");
  EXPECT_EQ(drive_.answer(pdu_of("06 00 D4 00 01")).deaf_for, 0ms);
}

TEST_F(StepperModel, TakesMoreThanATenthOfASecondToSaveOrRestore) {
  answer_of(drive_, "06 00 0A 03 E8");
  const auto saved = drive_.answer(pdu_of("06 00 DC 00 01"));
  EXPECT_EQ(saved.delay, 120ms);
  EXPECT_EQ(answer_of(drive_, "03 00 0A 00 01"), "03 02 03 E8");
  EXPECT_EQ(drive_.answer(pdu_of("06 00 DC 00 00")).delay, 120ms);
  EXPECT_EQ(answer_of(drive_, "03 00 0A 00 01"), "03 02 00 FA");
}

TEST_F(StepperModel, ReadsOneRegisterWithFunction04) {
  EXPECT_EQ(answer_of(drive_, "04 00 D8 00 01"), "04 02 75 30");
  EXPECT_EQ(answer_of(drive_, "04 00 D8 00 02"), "84 03");
}

TEST_F(StepperModel, AnswersTheStandardsExceptions) {
  EXPECT_EQ(answer_of(drive_, "01 00 00 00 01"), "81 01");
  EXPECT_EQ(answer_of(drive_, "03 00 23 00 01"), "83 02");  // a gap in the list
  EXPECT_EQ(answer_of(drive_, "03 00 C8 00 01"), "83 02");  // write only
  EXPECT_EQ(answer_of(drive_, "06 00 04 00 01"), "86 02");  // read only
  EXPECT_EQ(answer_of(drive_, "06 00 C8 00 02"), "86 03");  // neither run nor stop
  EXPECT_EQ(answer_of(drive_, "06 00 DC 00 02"), "86 03");
  EXPECT_EQ(answer_of(drive_, "10 00 D8 00 02 04 FF FF 7F FF"), "90 03");
}

TEST_F(StepperModel, TakesTwoHundredBytesOfTableDataAtOnce) {
  const auto request = [](unsigned registers) {
    std::vector<std::uint8_t> pdu{0x10,
                                  0x01,
                                  0xF4,
                                  0,
                                  static_cast<std::uint8_t>(registers),
                                  static_cast<std::uint8_t>(2 * registers)};
    pdu.resize(pdu.size() + std::size_t{2} * registers, 0x11);
    return *modbus::Pdu::from(pdu);
  };
  EXPECT_EQ(hex(drive_.answer(request(100)).response->bytes()), "10 01 F4 00 64");
  EXPECT_EQ(hex(drive_.answer(request(101)).response->bytes()), "90 03");
  EXPECT_EQ(drive_.registers().get(0x01F4 + 99), 0x1111U);
}

TEST_F(StepperModel, AnswersEveryPrintedRequest) {
  std::map<unsigned, modbus::Pdu> answers;
  unsigned echoes = 0;
  for (const manuals::Frame& frame : manuals::load_rtu()) {
    if (frame.manual != "rs485-stepper") {
      continue;
    }
    const modbus::Pdu pdu = modbus::decode_rtu(frame.bytes)->pdu;
    if (frame.direction == manuals::Direction::request) {
      if (const auto answer = drive_.answer(pdu).response) {
        answers.emplace(frame.line, *answer);
        EXPECT_FALSE(answer->is_exception()) << frame.where();
      } else {
        EXPECT_EQ(hex(pdu.bytes()), "06 00 D4 01 00") << frame.where();
      }
    } else if (frame.answers && answers.contains(*frame.answers)) {
      const modbus::Pdu& answer = answers.at(*frame.answers);
      EXPECT_EQ(answer.function(), pdu.function()) << frame.where();
      EXPECT_EQ(answer.size(), pdu.size()) << frame.where();
      if (pdu.function() != 0x03 && pdu.function() != 0x04) {
        EXPECT_EQ(hex(answer.bytes()), hex(pdu.bytes())) << frame.where();
        ++echoes;
      }
    }
  }
  EXPECT_GT(echoes, 50U);
}

TEST_F(StepperModel, HearsBroadcastWritesOnly) {
  const auto reaction = drive_.hear_broadcast(pdu_of("10 00 D0 00 02 04 27 10 00 00"));
  EXPECT_FALSE(reaction.response);
  EXPECT_EQ(position(), 10000U);
  EXPECT_EQ(drive_.hear_broadcast(pdu_of("06 00 D4 01 00")).deaf_for, 500ms);
  EXPECT_FALSE(drive_.hear_broadcast(pdu_of("03 00 04 00 02")).response);
}

}  // namespace
}  // namespace mbgate::test::stepper_drive_test
