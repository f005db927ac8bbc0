// SPDX-License-Identifier: Apache-2.0
#include "bus/device_health.hpp"

#include <gtest/gtest.h>

namespace mbgate::test {
namespace {

using namespace std::chrono_literals;
using bus::DeviceHealth;
using bus::Instant;

class Health : public testing::Test {
 protected:
  Health() { timing_.response_timeout = 100ms; }
  static Instant at(bus::Duration time) { return Instant{} + time; }
  [[nodiscard]] bool may_be_asked(bus::Duration time) const {
    return at(time) >= health_.held_until(timing_);
  }

  drive::DeviceTiming timing_;
  DeviceHealth health_;
};

TEST_F(Health, ADeviceThatOwesNothingIsNotHeldBack) {
  EXPECT_TRUE(may_be_asked(0s));
  EXPECT_EQ(health_.owed(at(0s), timing_), 0U);
  EXPECT_FALSE(health_.note_unexpected(at(1s), timing_));
}

TEST_F(Health, AQuarantineCountsFromTheLastUnansweredTransmission) {
  health_.note_unanswered(at(100ms), timing_);
  EXPECT_FALSE(may_be_asked(199ms));
  health_.note_unanswered(at(210ms), timing_);
  EXPECT_EQ(health_.owed(at(220ms), timing_), 2U);
  EXPECT_FALSE(may_be_asked(309ms));
  EXPECT_TRUE(may_be_asked(310ms));
  EXPECT_EQ(health_.owed(at(310ms), timing_), 0U);
}

TEST_F(Health, ItsLengthCanBeSet) {
  timing_.quarantine = 500ms;
  health_.note_unanswered(at(100ms), timing_);
  EXPECT_FALSE(may_be_asked(599ms));
  EXPECT_TRUE(may_be_asked(600ms));
}

TEST_F(Health, ItEndsWhenAllOwedAnswersWereSeen) {
  health_.note_unanswered(at(100ms), timing_);
  health_.note_unanswered(at(210ms), timing_);
  const auto first = health_.note_unexpected(at(215ms), timing_);
  ASSERT_TRUE(first);
  EXPECT_EQ(first->lateness, 115ms);
  EXPECT_FALSE(may_be_asked(216ms));
  const auto second = health_.note_unexpected(at(220ms), timing_);
  ASSERT_TRUE(second);
  EXPECT_EQ(second->lateness, 10ms);
  EXPECT_TRUE(may_be_asked(221ms));
}

TEST_F(Health, AReadThatWasRepeatedAndThenAnsweredLeavesItHeldBack) {
  health_.note_unanswered(at(100ms), timing_);
  health_.note_answered(at(210ms), at(120ms));  // whose answer was it?
  EXPECT_FALSE(may_be_asked(309ms));
  EXPECT_TRUE(may_be_asked(310ms));
}

TEST_F(Health, TheSecondAnswerProvesThatTheFirstWasLate) {
  health_.note_unanswered(at(100ms), timing_);
  health_.note_answered(at(210ms), at(190ms));
  const auto late = health_.note_unexpected(at(195ms), timing_);
  ASSERT_TRUE(late);
  EXPECT_EQ(late->lateness, 90ms);
  EXPECT_TRUE(may_be_asked(196ms));
}

TEST_F(Health, ItGrowsToCoverWhatWasSeenAndShrinksAgain) {
  health_.note_unanswered(at(100ms), timing_);
  health_.note_asked();  // the quarantine was over
  const auto late = health_.note_unexpected(at(500ms), timing_);
  ASSERT_TRUE(late);
  EXPECT_EQ(late->lateness, 400ms);
  EXPECT_TRUE(late->grew);
  EXPECT_EQ(health_.quarantine(at(500ms), timing_), 500ms);
  EXPECT_EQ(health_.quarantine(at(61s), timing_), 437500us);
  EXPECT_EQ(health_.quarantine(at(1h), timing_), 100ms);
}

TEST_F(Health, ItGrowsNoFurtherThanAllowed) {
  timing_.quarantine_max = 300ms;
  health_.note_unanswered(at(100ms), timing_);
  EXPECT_TRUE(health_.note_unexpected(at(390ms), timing_));
  EXPECT_EQ(health_.quarantine(at(390ms), timing_), 300ms);
  health_.note_unanswered(at(1s), timing_);
  EXPECT_FALSE(health_.note_unexpected(at(1301ms), timing_));  // too late to be believed
}

TEST_F(Health, MoreAnswersCanBeOwedThanAreDated) {
  for (int times = 0; times < 13; ++times) {
    health_.note_unanswered(at(100ms), timing_);
  }
  for (int times = 0; times < 12; ++times) {
    EXPECT_TRUE(health_.note_unexpected(at(110ms), timing_));
    EXPECT_FALSE(may_be_asked(111ms)) << times;
  }
  EXPECT_TRUE(health_.note_unexpected(at(110ms), timing_));
  EXPECT_TRUE(may_be_asked(111ms));
}

TEST_F(Health, ADamagedAnswerLeavesItHeldBackAndSaysNothingAboutWhetherItIsThere) {
  health_.note_spoilt(at(100ms));
  EXPECT_FALSE(may_be_asked(199ms));
  EXPECT_TRUE(may_be_asked(200ms));
  EXPECT_EQ(health_.unanswered_in_row(), 0U);
}

TEST_F(Health, ADeviceGoesOfflineAndComesBack) {
  EXPECT_FALSE(health_.note_unanswered(at(100ms), timing_));
  EXPECT_FALSE(health_.note_unanswered(at(200ms), timing_));
  EXPECT_TRUE(health_.note_unanswered(at(300ms), timing_));
  EXPECT_TRUE(health_.is_offline());
  EXPECT_FALSE(health_.note_unanswered(at(400ms), timing_));
  EXPECT_TRUE(health_.note_answered(at(500ms), at(450ms)));
  EXPECT_FALSE(health_.is_offline());
  EXPECT_FALSE(health_.note_answered(at(600ms), at(550ms)));
}

TEST_F(Health, ALateAnswerBringsItBack) {
  timing_.offline_after = 1;
  EXPECT_TRUE(health_.note_unanswered(at(100ms), timing_));
  const auto late = health_.note_unexpected(at(150ms), timing_);
  ASSERT_TRUE(late);
  EXPECT_TRUE(late->back);
  EXPECT_FALSE(health_.is_offline());
}

TEST_F(Health, OfflineCanBeTurnedOff) {
  timing_.offline_after = 0;
  for (int times = 0; times < 100; ++times) {
    EXPECT_FALSE(health_.note_unanswered(at(100ms), timing_));
  }
}

}  // namespace
}  // namespace mbgate::test
