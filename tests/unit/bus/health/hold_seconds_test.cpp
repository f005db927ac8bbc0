// SPDX-License-Identifier: Apache-2.0
// Second answers to one request.
#include "bus/health/hold.hpp"
#include "health_rig.hpp"

namespace mbgate::test {
namespace {

TEST_F(Health, ASuddenAnswerIsGivenTimeForAnother) {
  answered(read_, kAnswer, 100ms, 5ms);
  EXPECT_TRUE(may_be_asked(5ms));
  answered(read_, kAnswer, 200ms, 2ms);
  EXPECT_FALSE(may_be_asked(126ms));
  EXPECT_TRUE(may_be_asked(127ms));  // its longest answer and an adapter's 20 ms later
  answered(read_, kAnswer, 300ms, 3ms);
  EXPECT_TRUE(may_be_asked(203ms));
}

TEST_F(Health, ADeviceThatAnswersTwiceIsLeftAloneAfterEachAnswer) {
  auto now = 100ms;
  for (int times = 0; times < 8; ++times, now += 1s) {
    answered(read_, kAnswer, now, 5ms);
    EXPECT_TRUE(hold_.note_second(kAnswer, at(now - 100ms + 14ms), timing_));
    EXPECT_EQ(may_be_asked(now - 1ms), times == 7);  // a response timeout, until it is known better
  }
  answered(read_, kAnswer, now, 5ms);
  EXPECT_FALSE(may_be_asked(now - 95ms + 31249us));  // 9 ms, a quarter more, and 20 ms
  EXPECT_TRUE(may_be_asked(now - 95ms + 31250us));
}

// It was asked something else before it answered twice.
TEST_F(Health, ASecondAnswerMayBelongToARequestBeforeTheLastOne) {
  answered(read_, kAnswer, 100ms, 5ms);
  answered(write_, kEcho, 107ms, 3ms);
  answered(write_, kEcho, 112ms, 3ms);
  EXPECT_TRUE(hold_.note_second(kAnswer, at(40ms), timing_));
  EXPECT_FALSE(may_be_asked(114ms));  // a response timeout after the last answer
  EXPECT_TRUE(may_be_asked(115ms));
}

TEST_F(Health, ASecondAnswerThatHasComeIsNotOwedAnyMore) {
  answered(read_, kAnswer, 100ms, 5ms);
  EXPECT_TRUE(hold_.note_second(kAnswer, at(14ms), timing_));
  EXPECT_EQ(owed(read_), 0U);
  answered(read_, kAnswer, 300ms, 5ms);
  EXPECT_EQ(owed(read_), 1U);
  EXPECT_TRUE(hold_.note_second(kAnswer, at(214ms), timing_));
  EXPECT_EQ(owed(read_), 0U);
}

TEST_F(Health, SecondAnswersAreForgotten) {
  answered(read_, kAnswer, 100ms, 5ms);
  EXPECT_TRUE(hold_.note_second(kAnswer, at(14ms), timing_));
  for (int times = 1; times <= 200; ++times) {
    answered(read_, kAnswer, 1s * times, 5ms);
  }
  EXPECT_EQ(hold_.seconds(), 0U);
  EXPECT_TRUE(may_be_asked(200s - 95ms));
}

TEST_F(Health, WhatComesLaterOrFitsInNothingIsNoSecondAnswer) {
  EXPECT_FALSE(hold_.note_second(kAnswer, at(1ms), timing_));
  answered(read_, kAnswer, 100ms, 5ms);
  EXPECT_FALSE(hold_.note_second(kEcho, at(14ms), timing_));
  EXPECT_FALSE(hold_.note_second(kAnswer, at(106ms), timing_));
}

}  // namespace
}  // namespace mbgate::test
