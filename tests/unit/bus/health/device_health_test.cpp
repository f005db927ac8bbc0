// SPDX-License-Identifier: Apache-2.0
#include "health_rig.hpp"

namespace mbgate::test {
namespace {

TEST_F(Health, ALateAnswerIsOneMoreThatItIsThere) {
  timing_.offline_after = 2;
  unanswered(read_, 100ms);
  EXPECT_TRUE(unanswered(read_, 210ms));
  const auto late = health_.note_unexpected(kAnswer, at(220ms), timing_);
  ASSERT_TRUE(late);
  EXPECT_TRUE(late->back);
  EXPECT_FALSE(unanswered(read_, 500ms));  // the first in a row
  EXPECT_TRUE(unanswered(read_, 900ms));
}

TEST_F(Health, ADeviceThatOwesNothingIsNotHeldBack) {
  EXPECT_TRUE(may_be_asked(0s));
  EXPECT_EQ(health_.owed(3, at(0s), timing_), 0U);
  EXPECT_FALSE(health_.note_unexpected(kAnswer, at(1s), timing_));
}

TEST_F(Health, AQuarantineCountsFromTheLastUnansweredTransmission) {
  unanswered(read_, 100ms);
  EXPECT_FALSE(may_be_asked(219ms));
  unanswered(read_, 210ms);
  EXPECT_EQ(health_.owed(3, at(220ms), timing_), 2U);
  EXPECT_FALSE(may_be_asked(329ms));
  EXPECT_TRUE(may_be_asked(330ms));
  EXPECT_EQ(health_.owed(3, at(330ms), timing_), 0U);
}

TEST_F(Health, ItsLengthCanBeSet) {
  timing_.quarantine = 500ms;
  unanswered(read_, 100ms);
  EXPECT_FALSE(may_be_asked(619ms));
  EXPECT_TRUE(may_be_asked(620ms));
}

TEST_F(Health, ItEndsWhenAllOwedAnswersWereSeen) {
  unanswered(read_, 100ms);
  unanswered(read_, 210ms);
  const auto first = health_.note_unexpected(kAnswer, at(215ms), timing_);
  ASSERT_TRUE(first);
  EXPECT_EQ(first->lateness, 115ms);
  EXPECT_FALSE(may_be_asked(216ms));
  const auto second = health_.note_unexpected(kAnswer, at(220ms), timing_);
  ASSERT_TRUE(second);
  EXPECT_EQ(second->lateness, 10ms);
  EXPECT_TRUE(may_be_asked(221ms));
}

TEST_F(Health, AReadThatWasRepeatedAndThenAnsweredLeavesItHeldBack) {
  unanswered(read_, 100ms);
  answered(read_, kAnswer, 210ms, 10ms, 120ms);  // whose answer was it?
  EXPECT_FALSE(may_be_asked(329ms));
  EXPECT_TRUE(may_be_asked(330ms));
}

TEST_F(Health, TheSecondAnswerProvesThatTheFirstWasLate) {
  unanswered(read_, 100ms);
  answered(read_, kAnswer, 210ms, 10ms, 190ms);
  const auto late = health_.note_unexpected(kAnswer, at(195ms), timing_);
  ASSERT_TRUE(late);
  EXPECT_EQ(late->lateness, 90ms);
  EXPECT_TRUE(may_be_asked(196ms));
}

TEST_F(Health, ItGrowsToCoverWhatWasSeenAndShrinksAgain) {
  unanswered(read_, 100ms);
  health_.note_asked(at(220ms), timing_);  // the quarantine was over
  const auto late = health_.note_unexpected(kAnswer, at(500ms), timing_);
  ASSERT_TRUE(late);
  EXPECT_EQ(late->lateness, 400ms);
  EXPECT_TRUE(late->grew);
  EXPECT_EQ(health_.quarantine(at(500ms), timing_), 500ms);
  EXPECT_EQ(health_.quarantine(at(61s), timing_), 437500us);
  EXPECT_EQ(health_.quarantine(at(1h), timing_), 100ms);
}

TEST_F(Health, ItGrowsNoFurtherThanAllowed) {
  timing_.quarantine_max = 300ms;
  unanswered(read_, 100ms);
  EXPECT_TRUE(health_.note_unexpected(kAnswer, at(390ms), timing_));
  EXPECT_EQ(health_.quarantine(at(390ms), timing_), 300ms);
  unanswered(read_, 1s);
  EXPECT_FALSE(health_.note_unexpected(kAnswer, at(1321ms), timing_));  // too late to be believed
}

// A request of another function, or a stop, may go while it lasts.
TEST_F(Health, WhatAnAdapterKeepsIsOwedInTheLongestQuarantineToo) {
  timing_.quarantine = timing_.quarantine_max = 300ms;
  unanswered(read_, 1s);
  health_.note_asked(at(1310ms), timing_);
  EXPECT_EQ(health_.owed(3, at(1319ms), timing_), 1U);
  EXPECT_FALSE(may_be_asked(1319ms));
  EXPECT_TRUE(may_be_asked(1320ms));
  const auto late = health_.note_unexpected(kAnswer, at(1319ms), timing_);
  ASSERT_TRUE(late);
  EXPECT_EQ(late->lateness, 319ms);
  EXPECT_EQ(health_.quarantine(at(1319ms), timing_), 300ms);
}

TEST_F(Health, MoreAnswersCanBeOwedThanAreDated) {
  for (int times = 0; times < 13; ++times) {
    unanswered(read_, 100ms);
  }
  for (int times = 0; times < 12; ++times) {
    EXPECT_TRUE(health_.note_unexpected(kAnswer, at(110ms), timing_));
    EXPECT_FALSE(may_be_asked(111ms)) << times;
  }
  EXPECT_TRUE(health_.note_unexpected(kAnswer, at(110ms), timing_));
  EXPECT_TRUE(may_be_asked(111ms));
}

TEST_F(Health, ADamagedAnswerLeavesItHeldBackAndSaysNothingAboutWhetherItIsThere) {
  health_.note_spoilt(read_, at(100ms));
  EXPECT_FALSE(may_be_asked(219ms));
  EXPECT_TRUE(may_be_asked(220ms));
  EXPECT_EQ(health_.unanswered_in_row(), 0U);
}

TEST_F(Health, AFrameThatFitsNoOwedRequestProvesNothing) {
  unanswered(read_, 100ms);
  EXPECT_FALSE(health_.note_unexpected(unhex("03 04 12 34 56 78"), at(110ms), timing_));
  EXPECT_FALSE(health_.note_unexpected(unhex("06 00 00 00 01"), at(110ms), timing_));
  EXPECT_FALSE(health_.note_unexpected(unhex("86 02"), at(110ms), timing_));
  EXPECT_TRUE(health_.note_unexpected(unhex("83 02"), at(110ms), timing_));
}

TEST_F(Health, WhatWasGivenUpIsForgottenWhenTheDeviceAnswersOthers) {
  unanswered(read_, 100ms);
  health_.note_asked(at(300ms), timing_);
  answered(write_, unhex("06 00 00 00 01"), 400ms, 10ms, 310ms);
  EXPECT_FALSE(health_.note_unexpected(kAnswer, at(320ms), timing_));
}

TEST_F(Health, AnAnswerThatSlippedByOneIsLearnedFrom) {
  unanswered(read_, 100ms);
  health_.note_asked(at(300ms), timing_);
  answered(read_, kAnswer, 400ms, 10ms, 310ms);  // of the first one
  const auto late = health_.note_unexpected(kAnswer, at(320ms), timing_);
  ASSERT_TRUE(late);
  EXPECT_TRUE(late->grew);
  answered(read_, kAnswer, 500ms, 10ms, 410ms);
  EXPECT_FALSE(health_.note_unexpected(kAnswer, at(420ms), timing_));
}

TEST_F(Health, ADeviceThatHasAnsweredSinceIsHeldBackForTheSameFunctionOnly) {
  unanswered(read_, 100ms);
  EXPECT_FALSE(may_be_asked(write_, 219ms));
  answered(read_, kAnswer, 210ms, 8ms, 120ms);  // the retry's, or the first's
  EXPECT_FALSE(may_be_asked(write_, 151ms));
  EXPECT_TRUE(may_be_asked(write_, 152ms));  // four times its longest answer later
  EXPECT_FALSE(may_be_asked(read_, 329ms));
  EXPECT_TRUE(may_be_asked(read_, 330ms));
}

TEST_F(Health, ARequestOfAnotherFunctionNeitherClearsNorReplacesADebt) {
  unanswered(read_, 100ms);
  answered(read_, kAnswer, 210ms, 1ms, 120ms);
  health_.note_asked(at(140ms), timing_);
  answered(write_, unhex("06 00 00 00 01"), 250ms, 1ms, 141ms);
  EXPECT_EQ(health_.owed(3, at(142ms), timing_), 1U);
  EXPECT_EQ(health_.owed(6, at(142ms), timing_), 0U);
  EXPECT_FALSE(may_be_asked(read_, 329ms));
  EXPECT_TRUE(may_be_asked(read_, 330ms));
}

TEST_F(Health, SilenceAgainHoldsEverythingBack) {
  unanswered(read_, 100ms);
  answered(read_, kAnswer, 210ms, 1ms, 120ms);
  unanswered(write_, 300ms);
  EXPECT_FALSE(may_be_asked(read_, 419ms));
  EXPECT_TRUE(may_be_asked(read_, 420ms));
}

// The quarantine is the device's: another function makes it last for all.
TEST_F(Health, SilenceAgainKeepsWhatWasOwed) {
  const auto echo = unhex("06 0000 0001");
  unanswered(write_, 100ms);
  answered(write_, echo, 210ms, 1ms, 120ms);  // the other one is owed until 330 ms
  health_.note_asked(at(300ms), timing_);
  health_.note_written();
  unanswered(request("10 0005 0001 02 0001"), 400ms);
  health_.note_asked(at(340ms), timing_);  // a stop has ended the wait for it
  EXPECT_EQ(health_.owed_alike(write_, at(340ms), timing_), 1U);
  EXPECT_EQ(health_.owed_alike(write_, at(519ms), timing_), 1U);
  EXPECT_EQ(health_.owed_alike(write_, at(520ms), timing_), 0U);
}

TEST_F(Health, WhatThereIsNoRoomForHoldsEverythingBack) {
  for (int value = 0; value < 12; ++value) {
    unanswered(request("06 0000 00" + std::to_string(10 + value)), 100ms);
  }
  answered(read_, kAnswer, 210ms, 1ms, 120ms);
  EXPECT_FALSE(may_be_asked(read_, 219ms));
  EXPECT_TRUE(may_be_asked(read_, 220ms));
}

TEST_F(Health, WhatIsForgottenCountsFromTheLastUnansweredTransmissionToo) {
  const auto write = [](int value) { return "06 0000 00" + std::to_string(value); };
  for (int value = 10; value < 19; ++value) {
    unanswered(request(write(value)), 100ms);
  }
  unanswered(request(write(19)), 150ms);
  for (int value = 12; value < 20; ++value) {
    EXPECT_TRUE(health_.note_unexpected(unhex(write(value)), at(160ms), timing_));
  }
  EXPECT_FALSE(may_be_asked(read_, 269ms));
  EXPECT_TRUE(may_be_asked(read_, 270ms));
}

// A dead drive is sent a stop again and again, and other writes between.
TEST_F(Health, WhatWasAskedLastIsRememberedThoughItWasAskedFirstToo) {
  unanswered(write_, 100ms);
  for (int value = 0; value < 7; ++value) {
    unanswered(request("06 0000 00" + std::to_string(10 + value)), 110ms);
  }
  unanswered(write_, 120ms);
  unanswered(request("06 0000 0030"), 130ms);
  answered(write_, unhex("06 0000 0001"), 240ms, 1ms, 150ms);
  EXPECT_EQ(health_.owed(6, at(150ms), timing_), 9U);  // of the two alike one more
  EXPECT_FALSE(may_be_asked(write_, 359ms));
  EXPECT_TRUE(may_be_asked(write_, 360ms));
}

TEST_F(Health, AnAnswerMayBeThatToARequestForWhichThereWasNoRoom) {
  for (int value = 0; value < 12; ++value) {
    unanswered(request("06 0000 00" + std::to_string(10 + value)), 100ms);
  }
  const auto echo = unhex("06 0000 0010");
  answered(request("06 0000 0010"), echo, 210ms, 1ms, 120ms);
  EXPECT_FALSE(may_be_asked(write_, 329ms));
  EXPECT_TRUE(may_be_asked(write_, 330ms));
}

}  // namespace
}  // namespace mbgate::test
