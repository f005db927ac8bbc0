// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "bus/health/hold.hpp"

namespace mbgate::bus {
namespace {

using namespace std::chrono_literals;

class Pace : public testing::Test {
 protected:
  static Instant after(Duration time) { return Instant{1h} + time; }
  void answer(Duration took, Duration time) { pace_.note_answer(took, took, after(time)); }

  AnswerPace pace_;
};

TEST_F(Pace, KnowsTheLongestAnswerOfThisMinuteAndOfTheOneBefore) {
  EXPECT_EQ(pace_.longest_answer(), 0ms);
  answer(8ms, 0s);
  answer(30ms, 10s);
  answer(5ms, 20s);
  EXPECT_EQ(pace_.longest_answer(), 30ms);
  answer(5ms, 60s);
  EXPECT_EQ(pace_.longest_answer(), 30ms);
  EXPECT_EQ(pace_.longest_ordinary(), 30ms);
  answer(6ms, 120s);
  EXPECT_EQ(pace_.longest_answer(), 6ms);
}

TEST_F(Pace, ForgetsTheLongestAnswerWhereNoneCameForTwoMinutes) {
  answer(30ms, 0s);
  answer(5ms, 120s);
  EXPECT_EQ(pace_.longest_answer(), 5ms);
}

// Nobody can tell whether the first try was answered, slowly, or the second one, quickly.
TEST_F(Pace, TakesAnAnswerForThatOfTheFirstTryUnlessSuchQuickOnesAreUsual) {
  pace_.note_answer(2ms, 110ms, after(0s));
  EXPECT_EQ(pace_.longest_answer(), 110ms);
  answer(8ms, 180s);
  pace_.note_answer(8ms, 110ms, after(181s));
  EXPECT_EQ(pace_.longest_answer(), 8ms);
  pace_.note_answer(6ms, 110ms, after(182s));
  EXPECT_EQ(pace_.longest_answer(), 110ms);
}

TEST_F(Pace, AnAnswerAnEighthSoonerThanAnyOtherIsSudden) {
  EXPECT_FALSE(pace_.note_answer(80ms, 80ms, after(0s)));
  EXPECT_FALSE(pace_.note_answer(70ms, 70ms, after(1s)));
  answer(80ms, 180s);
  EXPECT_TRUE(pace_.note_answer(69999us, 69999us, after(181s)));
}

TEST_F(Pace, LearnsHowLateAnswersAreAndForgetsAnEighthInEachMinute) {
  EXPECT_EQ(pace_.learned(after(0s)), 0ms);
  pace_.note_late(800ms, after(0s));
  EXPECT_EQ(pace_.learned(after(0s)), 800ms);
  EXPECT_EQ(pace_.learned(after(59s)), 800ms);
  EXPECT_EQ(pace_.learned(after(60s)), 700ms);
  EXPECT_EQ(pace_.learned(after(120s)), 612500us);
  EXPECT_LT(pace_.learned(after(24h)), 10us);
}

TEST_F(Pace, IsTaughtNothingByAnAnswerThatIsCoveredAlready) {
  pace_.note_late(800ms, after(0s));
  pace_.note_late(700ms, after(30s));
  EXPECT_EQ(pace_.learned(after(60s)), 700ms);
  pace_.note_late(750ms, after(60s));  // now it is not
  EXPECT_EQ(pace_.learned(after(119s)), 750ms);
}

TEST_F(Pace, ForgetsNothingWhileAnswersComeThatWouldNotBeCoveredThen) {
  pace_.note_late(800ms, after(0s));
  pace_.note_late(800ms, after(30s));  // as much as quarantine_max allows, say
  EXPECT_EQ(pace_.learned(after(89s)), 800ms);
  pace_.note_late(701ms, after(89s));
  EXPECT_EQ(pace_.learned(after(148s)), 800ms);
  EXPECT_EQ(pace_.learned(after(149s)), 700ms);
}

}  // namespace
}  // namespace mbgate::bus
