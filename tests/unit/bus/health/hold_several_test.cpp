// SPDX-License-Identifier: Apache-2.0
// Several transmissions that a device has not answered.
#include <algorithm>

#include "bus/health/hold.hpp"
#include "health_rig.hpp"

namespace mbgate::test {
namespace {

// A later request that its answer would fit too is no retry, and its answer may have come.
TEST_F(Health, AReloadThatShortensATailDoesNotShortenARunningOne) {
  timing_.quarantine = 500ms;
  asked(0s);
  timing_.quarantine = 50ms;
  timing_.quarantine_max = 50ms;
  unanswered(read_, 100ms);
  EXPECT_FALSE(may_be_asked(619ms));
  EXPECT_TRUE(may_be_asked(620ms));
  asked(5s);
  EXPECT_EQ(owed(other_read_), 1U);
  asked(10020ms);
  EXPECT_EQ(owed(other_read_), 0U);
}

TEST_F(Health, AnotherRequestIsShownToBeLateByItsOwnTimeout) {
  unanswered(read_, 100ms);
  unanswered(other_read_, 210ms);
  const auto seen = late(kAnswer, 250ms);
  ASSERT_TRUE(seen);
  EXPECT_EQ(seen->shown, 40ms);
}

// The device was left alone for the answers to what was sent before.
TEST_F(Health, ARetryThatWasSentDuringAHoldIsOwedWhenTheHoldIsOver) {
  unanswered(read_, 100ms);
  answered(write_, kEcho, 250ms, 50ms);
  EXPECT_FALSE(may_be_asked(599ms));
  unanswered(read_, 690ms);
  asked(1s);
  EXPECT_EQ(owed(other_read_), 1U);
}

TEST_F(Health, OfManyUnansweredOnesTheOldestIsForgotten) {
  for (std::size_t count = 1; count <= bus::kMostUnanswered + 1; ++count) {
    unanswered(read_, 100ms);
    EXPECT_EQ(owed(read_), std::min(count, bus::kMostUnanswered));
  }
}

// The answer to a probe has shown that it owes nothing: what was missing before is no sign of how
// late it answers.
TEST_F(Health, TailsOfBeforeDoNotCountOnceItIsKnownToOweNothing) {
  timing_.quarantine_max = 2s;
  for (const auto due : {1s, 4s}) {
    unanswered(read_, due);
    asked(due + 1s);
    answered(write_, kEcho, due + 1100ms, 1ms);
  }
  unanswered(read_, 5600ms);
  hold_.note_asked(&read_, at(5700ms), timing_, false);
  ASSERT_TRUE(late(kAnswer, 5710ms, true));
  unanswered(read_, 5800ms);
  ASSERT_TRUE(hold_.note_asked(&read_, at(5900ms), timing_, false));
  answered(read_, kAnswer, 6s, 5ms);
  for (const auto due : {7s, 10s}) {
    unanswered(read_, due);
    asked(due + 900ms);
    EXPECT_TRUE(may_be_asked(due + 900ms));
  }
}

// Three in a minute were lost, but of the last eight only two.
TEST_F(Health, ADeviceThatAnswersMostRequestsWithinTheirTailsIsNotLeftAlone) {
  timing_.quarantine_max = 2s;
  for (const auto lost : {1s, 21s, 41s}) {
    unanswered(read_, lost);
    asked(lost + 1s);
    EXPECT_TRUE(may_be_asked(lost + 1s));
    for (auto due = lost + 4s; due < lost + 16s; due += 4s) {
      unanswered(read_, due);
      EXPECT_TRUE(late(kAnswer, due + 10ms));
    }
  }
}

// The driver may have slept while it came.
TEST_F(Health, TheFirstFrameAfterAHoldIsStillTheLateAnswer) {
  unanswered(read_, 100ms);
  unanswered(write_, 200ms);
  EXPECT_TRUE(late(kAnswer, 210ms));
  EXPECT_FALSE(may_be_asked(629ms));
  EXPECT_TRUE(may_be_asked(630ms));  // twice the 210 ms that the read took
  EXPECT_TRUE(late(kEcho, 640ms));
  EXPECT_FALSE(late(kEcho, 641ms));
}

// What was answered may have been the first try, after more than its timeout.
TEST_F(Health, ADeviceOfWhichOnlyTheSecondTryWasEverAnsweredIsHeldForAllFunctions) {
  unanswered(read_, 1s);
  answered(read_, kAnswer, 1110ms, 8ms);
  EXPECT_FALSE(may_be_asked(write_, 1253ms));
  EXPECT_TRUE(may_be_asked(write_, 1254ms));
}

// Nor does a damaged answer show that it is slow.
TEST_F(Health, OneWhoseFirstAnswerWasDamagedIsFast) {
  hold_.note_unanswered({read_, at(900ms), at(1s)}, true);
  answered(read_, kAnswer, 1050ms, 8ms);
  EXPECT_TRUE(may_be_asked(write_, 1050ms));
}

TEST_F(Health, ADeviceThatAnswersAProbeOnceMoreAtOnceOwesNothingElse) {
  unanswered(read_, 100ms);
  unanswered(read_, 2100ms);
  hold_.note_asked(&read_, at(4s), timing_, false);
  ASSERT_TRUE(late(kAnswer, 4010ms, true));
  unanswered(read_, 4100ms);
  EXPECT_FALSE(may_be_asked(read_, 4129ms)) << "as long as an answer may take, and an adapter";
  EXPECT_TRUE(may_be_asked(read_, 4130ms));
  EXPECT_TRUE(hold_.note_asked(&read_, at(4130ms), timing_, false));
  EXPECT_EQ(owed(read_), 0U);
  EXPECT_FALSE(may_be_asked(13s));
  answered(read_, kAnswer, 4230ms, 10ms);
  EXPECT_TRUE(may_be_asked(4140ms));
}

TEST_F(Health, ADeviceThatDoesNotIsHeldForWhatItOwes) {
  unanswered(read_, 100ms);
  unanswered(read_, 2100ms);
  hold_.note_asked(&read_, at(4s), timing_, false);
  ASSERT_TRUE(late(kAnswer, 4010ms, true));
  unanswered(read_, 4100ms);
  EXPECT_TRUE(hold_.note_asked(&read_, at(4110ms), timing_, false));
  unanswered(read_, 4210ms);
  EXPECT_FALSE(may_be_asked(13s));
  asked(13s);
  EXPECT_EQ(owed(read_), 2U);
}

TEST_F(Health, TailsBeforeItWasLeftAloneDoNotCountForTheNextTime) {
  timing_.quarantine_max = 2s;
  for (const auto due : {1s, 5s, 9s}) {
    unanswered(read_, due);
    asked(due + 1s);
    answered(write_, kEcho, due + 3100ms, 1ms);
  }
  unanswered(read_, 15min);
  asked(15min + 1s);
  EXPECT_TRUE(may_be_asked(15min + 1s));
}

// The hold after an earlier answer has ended; what comes at the last instant of the tail came in
// it.
TEST_F(Health, AnAnswerAtTheVeryEndOfATailIsThatOfTheFirstTry) {
  const auto write = request("10 0000 0001 02 0001");
  const auto stop = request("10 0000 0001 02 00E1");
  const auto done = unhex("10 0000 0001");
  unanswered(write, 100ms);
  hold_.note_asked(&stop, at(100ms), timing_, false);
  EXPECT_TRUE(late(done, 100ms));
  unanswered(stop, 200ms);
  hold_.note_asked(&stop, at(220ms), timing_, false);
  hold_.note_answered({stop, at(220ms), at(320ms), true}, done, 100ms, at(320ms), timing_);
  EXPECT_FALSE(may_be_asked(321ms));
  EXPECT_EQ(owed(write), 1U);
}

}  // namespace
}  // namespace mbgate::test
