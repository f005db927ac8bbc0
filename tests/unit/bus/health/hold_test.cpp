// SPDX-License-Identifier: Apache-2.0
#include "bus/health/hold.hpp"

#include "health_rig.hpp"

namespace mbgate::test {
namespace {

TEST_F(Health, ADeviceThatOwesNothingIsNotHeld) {
  EXPECT_TRUE(may_be_asked(0s));
  EXPECT_EQ(owed(read_), 0U);
  EXPECT_FALSE(late(kAnswer, 1s));
}

TEST_F(Health, ATailCountsFromTheLastUnansweredTransmission) {
  unanswered(read_, 100ms);
  EXPECT_FALSE(may_be_asked(219ms));
  unanswered(read_, 210ms);
  EXPECT_EQ(owed(read_), 2U);
  EXPECT_FALSE(may_be_asked(329ms));
  EXPECT_TRUE(may_be_asked(330ms));
}

TEST_F(Health, AnAnswerIsOwedBeyondItsTail) {
  unanswered(read_, 100ms);
  asked(5s);
  EXPECT_EQ(owed(other_read_), 1U);
  EXPECT_EQ(owed(write_), 0U);  // its answer has another function
  asked(10020ms);               // quarantine_max after it was sent, and an adapter's 20 ms
  EXPECT_EQ(owed(other_read_), 0U);
}

TEST_F(Health, TheLengthOfATailCanBeSet) {
  timing_.quarantine = 500ms;
  unanswered(read_, 100ms);
  EXPECT_FALSE(may_be_asked(619ms));
  EXPECT_TRUE(may_be_asked(620ms));
}

TEST_F(Health, AHoldEndsWhenAllOwedAnswersHaveCome) {
  unanswered(read_, 100ms);
  unanswered(read_, 210ms);
  const auto first = late(kAnswer, 215ms);
  ASSERT_TRUE(first);
  EXPECT_EQ(first->lateness, 5ms);  // that of the second one, if the first was lost
  EXPECT_FALSE(may_be_asked(216ms));
  const auto second = late(kAnswer, 220ms);
  ASSERT_TRUE(second);
  EXPECT_EQ(second->lateness, 115ms);
  EXPECT_TRUE(may_be_asked(221ms));
}

TEST_F(Health, AnAnswerToTheRetryIsTheFirstTrysAndTheDeviceIsHeldForTheOther) {
  unanswered(read_, 100ms);
  answered(read_, kAnswer, 210ms, 10ms);  // sent at 110 ms, answered 120 ms after the first try
  EXPECT_EQ(owed(read_), 1U);
  EXPECT_FALSE(may_be_asked(359ms));
  EXPECT_TRUE(may_be_asked(360ms));  // twice 120 ms later, as no more came
  asked(360ms);
  EXPECT_EQ(owed(read_), 0U);
}

TEST_F(Health, TheSecondAnswerProvesThatTheFirstWasLate) {
  unanswered(read_, 100ms);
  answered(read_, kAnswer, 210ms, 80ms);
  const auto second = late(kAnswer, 195ms);
  ASSERT_TRUE(second);
  EXPECT_EQ(second->lateness, 90ms);
  EXPECT_TRUE(may_be_asked(195ms));
}

TEST_F(Health, AnAnswerThatMayBeThatToALaterRequestShowsNoLatenessUntilOneMoreComes) {
  unanswered(read_, 100ms);
  hold_.note_asked(&other_read_, at(500ms), timing_, false);
  const auto first = late(kAnswer, 505ms);
  ASSERT_TRUE(first);
  EXPECT_EQ(first->lateness, 0ms);
  EXPECT_FALSE(first->grew);
  unanswered(other_read_, 600ms);
  const auto second = late(kAnswer, 650ms);
  ASSERT_TRUE(second);
  EXPECT_EQ(second->lateness, 405ms);
  EXPECT_TRUE(second->grew);
}

// The retry's answer may be lost; what the user has to know is how late the first one is.
TEST_F(Health, TheFirstTryIsShownToBeLateThoughItMayBeTheRetry) {
  hold_.note_unanswered({read_, at(0ms), at(100ms)});
  hold_.note_unanswered({read_, at(110ms), at(210ms), true});
  const auto seen = late(kAnswer, 250ms);
  ASSERT_TRUE(seen);
  EXPECT_EQ(seen->lateness, 40ms);
  EXPECT_EQ(seen->shown, 150ms);
}

TEST_F(Health, WhatAHoldHasWaitedForIsNotOwedThoughItsTailEndsLater) {
  answered(read_, kAnswer, 100ms, 5ms);
  unanswered(read_, 1s);
  answered(read_, kAnswer, 1110ms, 5ms);  // held until 1245 ms, and the tail ends at 1230 ms
  timing_.quarantine = 300ms;             // 1430 ms
  asked(1250ms);                          // of another function
  EXPECT_EQ(owed(read_), 1U);
  asked(1430ms);
  EXPECT_EQ(owed(read_), 0U);
}

TEST_F(Health, WhatIsPendingCountsForTheHold) {
  unanswered(read_, 100ms);
  hold_.note_asked(&other_read_, at(500ms), timing_, false);
  ASSERT_TRUE(late(kAnswer, 505ms));
  unanswered(other_read_, 600ms);
  EXPECT_FALSE(may_be_asked(1514ms));
  EXPECT_TRUE(may_be_asked(1515ms));  // twice 505 ms later
  asked(1515ms);
  EXPECT_EQ(owed(read_), 0U);
}

TEST_F(Health, ATailGrowsToCoverWhatWasSeenAndFades) {
  unanswered(read_, 100ms);
  const auto seen = late(kAnswer, 500ms);
  ASSERT_TRUE(seen);
  EXPECT_EQ(seen->lateness, 400ms);
  EXPECT_TRUE(seen->grew);
  EXPECT_EQ(hold_.tail(at(500ms), timing_), 500ms);
  EXPECT_EQ(hold_.tail(at(61s), timing_), 437500us);
  EXPECT_EQ(hold_.tail(at(1h), timing_), 100ms);
}

TEST_F(Health, ATailGrowsNoFurtherThanAllowed) {
  timing_.quarantine_max = 300ms;
  unanswered(read_, 100ms);
  EXPECT_TRUE(late(kAnswer, 310ms));
  EXPECT_EQ(hold_.tail(at(310ms), timing_), 262500us);
  unanswered(read_, 1s);
  EXPECT_TRUE(late(kAnswer, 1270ms));
  EXPECT_EQ(hold_.tail(at(1270ms), timing_), 300ms);
}

TEST_F(Health, AnUnreadableAnswerIsWaitedForUntilTheResponseTimeoutOnly) {
  hold_.note_unanswered({read_, at(0ms), at(100ms)}, true);
  EXPECT_FALSE(may_be_asked(99ms));
  EXPECT_TRUE(may_be_asked(100ms));
  asked(100ms);
  EXPECT_EQ(owed(read_), 0U);
}

TEST_F(Health, AFrameThatFitsNothingUnansweredProvesNothing) {
  unanswered(read_, 100ms);
  EXPECT_FALSE(late(unhex("03 04 12 34 56 78"), 110ms));
  EXPECT_FALSE(late(kEcho, 110ms));
  EXPECT_FALSE(late(unhex("86 02"), 110ms));
  EXPECT_TRUE(late(unhex("83 02"), 110ms));
}

TEST_F(Health, AFastDeviceThatHasAnsweredSinceIsHeldForTheSameFunctionOnly) {
  answered(read_, kAnswer, 100ms, 8ms);
  unanswered(read_, 1s);
  EXPECT_FALSE(may_be_asked(write_, 1119ms));
  answered(read_, kAnswer, 1110ms, 8ms);
  EXPECT_TRUE(may_be_asked(write_, 1018ms));
  EXPECT_FALSE(may_be_asked(read_, 1253ms));
  EXPECT_TRUE(may_be_asked(read_, 1254ms));
}

// Else it could not be written to while somebody polls it.
TEST_F(Health, FastAnswersToOthersDoNotLengthenItsHold) {
  answered(read_, kAnswer, 100ms, 8ms);
  unanswered(write_, 1s);
  for (auto due = 1110ms; due <= 1300ms; due += 50ms) {
    answered(read_, kAnswer, due, 8ms);
  }
  EXPECT_FALSE(may_be_asked(write_, 1253ms));
  EXPECT_TRUE(may_be_asked(write_, 1254ms));
  asked(1254ms);
  EXPECT_EQ(owed(write_), 0U);
}

TEST_F(Health, ASlowDeviceIsHeldForAllFunctions) {
  answered(read_, kAnswer, 100ms, 30ms);
  unanswered(read_, 1s);
  answered(read_, kAnswer, 1110ms, 8ms);
  EXPECT_FALSE(may_be_asked(write_, 1253ms));
  EXPECT_TRUE(may_be_asked(write_, 1254ms));
}

TEST_F(Health, SilenceAgainHoldsEverything) {
  answered(read_, kAnswer, 100ms, 1ms);
  unanswered(read_, 1s);
  answered(read_, kAnswer, 1110ms, 1ms);
  unanswered(write_, 1300ms);
  EXPECT_FALSE(may_be_asked(write_, 1419ms));
  EXPECT_FALSE(may_be_asked(request("04 0000 0001"), 1419ms));
}

TEST_F(Health, EarlierTriesAreItsOwnUnlessAnotherWriteWasSentSince) {
  unanswered(other_read_, 100ms);
  unanswered(read_, 300ms);
  unanswered(write_, 400ms);
  auto owed = owed_since(read_, 150ms);
  ASSERT_EQ(owed.size(), 2U);
  EXPECT_FALSE(owed[0].is_own);
  EXPECT_TRUE(owed[1].is_own);
  EXPECT_FALSE(owed_since(read_, 250ms)[1].is_own);
  EXPECT_TRUE(owed_since(write_, 300ms)[0].is_own);
  hold_.note_written(write_, false);
  hold_.note_written(request("06 0001 0001"), true);
  EXPECT_TRUE(owed_since(write_, 300ms)[0].is_own);
  hold_.note_written(request("06 0001 0001"), false);
  EXPECT_FALSE(owed_since(write_, 300ms)[0].is_own);
  EXPECT_TRUE(owed_since(read_, 150ms)[1].is_own);
}

// It was answered, or its echo came: it is no sign of a queue.
TEST_F(Health, WhatMayBeAnsweredHoldsNoOtherFunction) {
  hold_.note_unanswered({write_, at(0ms), at(100ms), false, true});
  EXPECT_TRUE(may_be_asked(read_, 100ms));
  EXPECT_FALSE(may_be_asked(write_, 219ms));
  unanswered(write_, 1100ms);
  late(kEcho, 1120ms);  // of one of them
  EXPECT_FALSE(may_be_asked(read_, 1359ms));
  EXPECT_TRUE(may_be_asked(read_, 1360ms));  // 120 ms of the second one, twice
}

// The echo of function 16 names no value.
TEST_F(Health, AnotherStopWhoseEchoLooksTheSameTakesTheProofAway) {
  const auto stop = request("10 0010 0001 02 0001");
  unanswered(stop, 100ms);
  hold_.note_written(request("10 0011 0001 02 0002"), true);
  EXPECT_TRUE(owed_since(stop, 0ms)[0].is_own);
  hold_.note_written(request("10 0010 0001 02 0002"), true);
  EXPECT_FALSE(owed_since(stop, 0ms)[0].is_own);
}

TEST_F(Health, ADeviceWhoseTailsEndUnansweredThoughItAnswersIsLeftAloneForOnce) {
  timing_.quarantine_max = 2s;
  for (const auto due : {1s, 4s}) {
    unanswered(read_, due);
    asked(due + 1s);
    answered(write_, kEcho, due + 1100ms, 1ms);
  }
  unanswered(read_, 7s);
  asked(7900ms);
  EXPECT_FALSE(may_be_asked(9899ms));
  EXPECT_TRUE(may_be_asked(9900ms));
}

TEST_F(Health, ADeviceThatLosesOneNowAndThenIsNotLeftAlone) {
  for (auto due = 1s; due < 10min; due += 31s) {
    unanswered(read_, due);
    asked(due + 1s);
    answered(write_, kEcho, due + 1100ms, 1ms);
    EXPECT_TRUE(may_be_asked(due + 4s));
  }
}

// The answer to the first try was lost, and its retry was answered.
TEST_F(Health, NorIsOneWhoseRetriesAreAnswered) {
  for (auto due = 1s; due < 20s; due += 3s) {
    unanswered(read_, due);
    answered(read_, kAnswer, due + 110ms, 10ms);
    asked(due + 1s);
    EXPECT_TRUE(may_be_asked(due + 1s));
  }
}

TEST_F(Health, OnceInTenMinutes) {
  timing_.quarantine_max = 2s;
  unsigned rests = 0;
  for (auto due = 1s; due < 20min; due += 4s) {
    unanswered(read_, due);
    asked(due + 1s);
    rests += may_be_asked(due + 1s) ? 0U : 1U;
    answered(write_, kEcho, due + 3100ms, 1ms);
  }
  EXPECT_EQ(rests, 2U);
}

TEST_F(Health, ADeadDeviceIsNotLeftAlone) {
  answered(read_, kAnswer, 200ms, 5ms);
  for (auto due = 1s; due < 60s; due += 3s) {
    asked(due - 100ms);
    unanswered(read_, due);
  }
  asked(60s);
  EXPECT_TRUE(may_be_asked(60s));
}

}  // namespace
}  // namespace mbgate::test
