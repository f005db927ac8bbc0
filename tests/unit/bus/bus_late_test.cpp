// SPDX-License-Identifier: Apache-2.0
// Answers that come after their time, before it, or that nobody asked for.
#include "bus_rig.hpp"

namespace mbgate::test {
namespace {

using Kind = bus::DeviceNotice::Kind;

constexpr auto kOther = "03 0010 0001";  // the same shape as kRead
constexpr auto kReadFrame = "01 03 00 00 00 01 84 0A";
constexpr auto kOtherFrame = "01 03 00 10 00 01 85 CF";
constexpr auto kOtherDevice = "02 03 00 00 00 01 84 39";

using BusLate = Bus;

TEST_F(BusLate, ADeviceIsLeftAloneWhileItsAnswerMayStillComeAndOthersGoOn) {
  open(settings());
  submit(job(kRead));
  submit(job_of(1, kOther));
  submit(job_of(1, kRead, 2));
  time_out();
  EXPECT_THAT(frames_, ElementsAre(kReadFrame, kOtherDevice));
  advance(50ms);
  line(kAnswer);  // late: nobody gets it, and the second client has its turn
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
  EXPECT_EQ(bus_->counters().late_responses, 1U);
  EXPECT_EQ(bus_->device_counters(1).late_responses, 1U);
  EXPECT_EQ(bus_->counters().foreign_frames, 0U);
  advance(60ms);
  EXPECT_THAT(frames_, ElementsAre(kReadFrame, kOtherDevice, kOtherFrame));
}

TEST_F(BusLate, ALateAnswerOnAQuietLineIsSeenToo) {
  open(settings());
  submit(job(kRead));
  time_out();
  advance(10ms);
  line(kAnswer);
  submit(job(kOther));
  EXPECT_EQ(bus_->held_back(1, now_), 0ms);
  EXPECT_EQ(until_next_frame(), kT35);
}

TEST_F(BusLate, TheQuarantineEndsByItself) {
  open(settings());
  submit(job(kRead));
  time_out();
  submit(job(kOther));
  EXPECT_EQ(bus_->held_back(1, now_), 120ms);  // 20 ms for what an adapter still keeps
  EXPECT_EQ(until_next_frame(), 120ms);
}

TEST_F(BusLate, ARetryOfTheSameReadGoesAtOnceAndNobodyJoinsIt) {
  auto retrying = settings();
  retrying.timing.retries = 1;
  retrying.coalesce = true;
  open(retrying);
  submit(job(kRead));
  time_out();
  submit(job_of(1, kRead));
  ASSERT_THAT(frames_, ElementsAre(kReadFrame, kReadFrame));
  advance(20ms);
  line(kAnswer);  // of the first or of the second transmission
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  advance(50ms);
  line(kAnswer);  // of the other one
  EXPECT_THAT(endings_, SizeIs(1));
  EXPECT_EQ(bus_->counters().late_responses, 1U);
  advance(10ms);
  EXPECT_THAT(frames_, SizeIs(3));
  advance(10ms);
  line(kAnswer);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::answered));
}

TEST_F(BusLate, AnAnswerThatBeginsBeforeTheRequestHasLeftIsAnOlderOne) {
  auto retrying = settings();
  retrying.timing.retries = 1;
  open(retrying);
  submit(job(kRead));
  time_out();
  ASSERT_THAT(frames_, SizeIs(2));
  advance(2ms);
  line(kAnswer);
  EXPECT_THAT(endings_, IsEmpty());
  EXPECT_EQ(bus_->counters().late_responses, 1U);
  advance(20ms);
  line("01 03 02 00 07 F9 86");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  EXPECT_EQ(jobs_[0].transactions[0].response, modbus::Pdu::from(unhex("03 02 00 07")));
  EXPECT_EQ(bus_->held_back(1, now_), 0ms);
}

TEST_F(BusLate, TheRightAnswerBehindAnOlderOneInTheSamePieceIsFound) {
  auto retrying = settings();
  retrying.timing.retries = 1;
  open(retrying);
  submit(job(kRead));
  time_out();
  advance(2ms);
  line(std::string(kAnswer) + " 01 03 02 00 07 F9 86");
  EXPECT_EQ(bus_->counters().late_responses, 1U);
  // Both begin at the instant of the piece as far as can be seen, and one more was owed than came.
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
}

TEST_F(BusLate, AnEarlyAnswerOfADeviceThatOwesNothingIsTakenAndToldOnce) {
  auto waiting = settings();
  waiting.timing.response_wait = 50ms;
  open(waiting);
  for (int times = 0; times < 2; ++times) {
    submit(job(kRead));
    advance(20ms);
    line(kAnswer);
    advance(10ms);
  }
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::answered));
  EXPECT_EQ(bus_->counters().early_responses, 2U);
  EXPECT_THAT(notices_, ElementsAre(Kind::early));
}

TEST_F(BusLate, AnEarlyAnswerIsRefusedWhileAnotherIsOwed) {
  auto waiting = settings();
  waiting.timing.response_wait = 50ms;
  waiting.timing.retries = 1;
  open(waiting);
  submit(job(kRead));
  advance(kEmission + 150ms);
  ASSERT_THAT(frames_, SizeIs(2));
  advance(20ms);
  line(kAnswer);
  EXPECT_THAT(endings_, IsEmpty());
  advance(40ms);
  line(kAnswer);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
}

TEST_F(BusLate, LatenessIsToldAndTheQuarantineGrows) {
  open(settings());
  submit(job(kRead));
  time_out();
  advance(96ms);
  line(kAnswer);
  ASSERT_THAT(notices_, ElementsAre(Kind::late));
  advance(10ms);
  submit(job(kRead));
  time_out();
  EXPECT_EQ(bus_->held_back(1, now_), 140ms);
}

TEST_F(BusLate, FramesOfDevicesThatOweNothingAreForeignTrafficAndToldOnce) {
  open(settings());
  advance(10s);  // what came earlier might have been for whoever had the line before
  line("02 03 02 12 34 F1 33");
  EXPECT_EQ(bus_->counters().foreign_frames, 1U);
  advance(10ms);
  line("02 03 00 00 00 01 84 39");  // another client's request
  advance(10ms);
  line("02 03 02 12 34 F1 33");
  EXPECT_EQ(bus_->counters().foreign_frames, 3U);
  EXPECT_THAT(notices_, ElementsAre(Kind::foreign));
}

TEST_F(BusLate, AnotherClientsRequestIsNoAnswer) {
  auto breaking = settings();
  breaking.timing.offline_after = 1;
  open(breaking);
  submit(job(kRead));
  time_out();
  line(kOtherFrame);
  advance(10ms);
  line("02");
  EXPECT_TRUE(bus_->is_offline(1));
  EXPECT_EQ(bus_->counters().late_responses, 0U);
}

TEST_F(BusLate, AWriteIsNotTakenForAnsweredByAnOlderAnswer) {
  open(settings());
  submit(job("06 0000 0001"));
  time_out();
  submit(job("06 0000 0001"));
  advance(50ms);
  line("01 06 00 00 00 01 48 0A");
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
  EXPECT_THAT(frames_, SizeIs(1));
  advance(10ms);
  EXPECT_THAT(frames_, SizeIs(2));
}

TEST_F(BusLate, ARepeatedWriteWaitsForTheQuarantine) {
  auto repeating = settings();
  repeating.timing.retry_writes = true;
  repeating.timing.retries = 1;
  open(repeating);
  submit(job("06 0000 0001"));
  submit(job_of(1, kRead, 2));
  time_out();
  ASSERT_THAT(frames_, SizeIs(2));
  EXPECT_EQ(frames_[1], kOtherDevice);
  advance(20ms);
  line("02 03 02 12 34 F1 33");
  advance(110ms);
  ASSERT_THAT(frames_, SizeIs(3));
  EXPECT_EQ(frames_[2], frames_[0]);
}

// The first answer of a read was lost, its retry was answered at once: a write is not for long
// behind it, and another read is.
TEST_F(BusLate, AWriteGoesSoonAfterARepeatedReadWasAnswered) {
  auto retrying = settings();
  retrying.timing.retries = 1;
  open(retrying);
  submit(job(kRead));
  time_out();
  advance(8ms);
  line(kAnswer);
  submit(job_of(1, kOther));
  submit(job_of(2, "06 0000 0001"));
  ASSERT_THAT(frames_, SizeIs(2));
  EXPECT_EQ(until_next_frame(), 20ms);
  EXPECT_EQ(frames_[2], "01 06 00 00 00 01 48 0A");
}

// What is owed is the answer to a read; the write between neither clears nor replaces that debt.
TEST_F(BusLate, AWriteBetweenLeavesTheReadsHeldBack) {
  auto retrying = settings();
  retrying.timing.retries = 1;
  open(retrying);
  submit(job(kRead));
  time_out();
  advance(8ms);
  line(kAnswer);
  submit(job_of(1, kOther));
  submit(job_of(2, "06 0000 0001"));
  advance(30ms);
  line("01 06 00 00 00 01 48 0A");
  ASSERT_THAT(frames_, SizeIs(3));
  advance(100ms);
  EXPECT_THAT(frames_, SizeIs(3));
  line(kAnswer);  // at last the other one of the first read
  EXPECT_EQ(bus_->counters().late_responses, 1U);
  advance(10ms);
  ASSERT_THAT(frames_, SizeIs(4));
  EXPECT_EQ(frames_.back(), kOtherFrame);
}

TEST_F(BusLate, AFrameOfAnotherLengthIsNoLateAnswer) {
  open(settings());
  submit(job(kRead));
  time_out();
  advance(10s);
  submit(job(kRead));
  advance(10ms);
  line(kAnswer);
  submit(job(kRead));
  advance(10ms);
  line("01 03 04 12 34 56 78 81 07");  // not what was asked for
  EXPECT_THAT(notices_, testing::Not(testing::Contains(Kind::late)));
  EXPECT_EQ(bus_->held_back(1, now_), 0ms);
}

TEST_F(BusLate, NoBroadcastComesBetweenThePartsOfAJobThatIsHeldBack) {
  auto retrying = settings();
  retrying.timing.retries = 1;
  open(retrying);
  bus::Job& parts = job(kRead);
  add(parts, kOther);
  submit(parts);
  submit(job_of(1, "06 0000 0001", 0));
  submit(job_of(2, kRead, 2));
  time_out();
  advance(20ms);
  line(kAnswer);  // of the second transmission: the first may still be answered
  advance(20ms);
  ASSERT_THAT(frames_, SizeIs(3));
  EXPECT_EQ(frames_[2], kOtherDevice);
}

TEST_F(BusLate, WhatWasOnTheWireWhenTheLineWasLostIsStillOwed) {
  open(settings());
  submit(job(kRead));
  bus_->handle_lost(now_);
  drain();
  bus_->handle_opened(now_ + 10ms);
  now_ += 10ms;
  EXPECT_EQ(bus_->held_back(1, now_), kEmission + 210ms);
}

TEST_F(BusLate, WhatLiesInTheLineBeforeATransmissionIsNoAnswerToIt) {
  open(settings());
  submit(job(kRead));
  time_out();
  advance(10s);
  unread_ = kAnswer;
  submit(job_of(1, kOther));
  EXPECT_THAT(frames_, SizeIs(1));  // the line is not silent
  advance(5ms);
  EXPECT_THAT(frames_, ElementsAre(kReadFrame, kOtherFrame));
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
}

TEST_F(BusLate, OnlyTheEndOfASilenceMayBeWokenForEarly) {
  open(settings());
  line(kAnswer);
  submit(job(kRead));
  EXPECT_TRUE(bus_->next_wake()->ends_silence);
  advance(5ms);
  EXPECT_FALSE(bus_->next_wake()->ends_silence);  // the response timeout
  time_out();
  submit(job_of(1, kOther));
  EXPECT_FALSE(bus_->next_wake()->ends_silence);  // the quarantine
}

TEST_F(BusLate, BytesThatAreNoFrameAreDrainedBeforeTheNextTransmission) {
  open(settings());
  line("12 34 56");
  EXPECT_EQ(bus_->line_state(now_), bus::LineState::draining);
  submit(job(kRead));
  EXPECT_EQ(until_next_frame(), kT35);
}

}  // namespace
}  // namespace mbgate::test
