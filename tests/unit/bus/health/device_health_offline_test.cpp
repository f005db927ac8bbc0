// SPDX-License-Identifier: Apache-2.0
// Late answers, and devices that go offline and come back.
#include "health_rig.hpp"

namespace mbgate::test {
namespace {

TEST_F(Health, ADeviceGoesOfflineAndComesBack) {
  EXPECT_FALSE(unanswered(read_, 100ms));
  EXPECT_FALSE(unanswered(read_, 200ms));
  EXPECT_TRUE(unanswered(read_, 300ms));
  EXPECT_TRUE(health_.is_offline());
  EXPECT_FALSE(unanswered(read_, 400ms));
  EXPECT_TRUE(answered(read_, kAnswer, 500ms, 10ms, 450ms));
  EXPECT_FALSE(health_.is_offline());
  EXPECT_FALSE(answered(read_, kAnswer, 600ms, 10ms, 550ms));
}

TEST_F(Health, ALateAnswerBringsItBack) {
  timing_.offline_after = 1;
  EXPECT_TRUE(unanswered(read_, 100ms));
  const auto late = health_.note_unexpected(kAnswer, at(150ms), timing_);
  ASSERT_TRUE(late);
  EXPECT_TRUE(late->back);
  EXPECT_FALSE(health_.is_offline());
}

TEST_F(Health, ALateAnswerToTheSameReadSentAgainBringsItBackThoughTheFirstIsTooOld) {
  timing_.offline_after = 2;
  timing_.quarantine_max = 1s;
  unanswered(read_, 100ms);
  EXPECT_TRUE(unanswered(read_, 900ms));
  const auto late = health_.note_unexpected(kAnswer, at(1200ms), timing_);
  ASSERT_TRUE(late);
  EXPECT_TRUE(late->back);
  EXPECT_EQ(late->lateness, 300ms);
  EXPECT_FALSE(health_.note_unexpected(kAnswer, at(2s), timing_));  // as old as the first was
}

TEST_F(Health, OfflineCanBeTurnedOff) {
  timing_.offline_after = 0;
  for (int times = 0; times < 100; ++times) {
    EXPECT_FALSE(unanswered(read_, 100ms));
  }
}

TEST_F(Health, ADeviceIsInTheStateOfItsLastRequest) {
  EXPECT_EQ(health_.state(), DeviceState::not_asked);
  health_.note_damaged(read_, at(100ms), at(50ms));
  EXPECT_EQ(health_.state(), DeviceState::damaged);
  unanswered(read_, 500ms);
  EXPECT_EQ(health_.state(), DeviceState::not_answering);
  health_.note_damaged(read_, at(800ms), at(750ms));
  EXPECT_EQ(health_.state(), DeviceState::damaged);
  answered(read_, kAnswer, 1100ms, 10ms, 1010ms);
  health_.note_damaged(read_, at(1200ms), at(1150ms));
  EXPECT_EQ(health_.state(), DeviceState::answering);
  for (const auto due : {2s, 3s, 4s}) {
    unanswered(read_, due);
  }
  EXPECT_EQ(health_.state(), DeviceState::offline);
}

TEST_F(Health, ADeviceThatAnswersIsDamagedAfterThreeInARow) {
  const auto damaged = [this](bus::Duration now) {
    health_.note_damaged(read_, at(now + 50ms), at(now));
  };
  answered(read_, kAnswer, 100ms, 10ms, 50ms);
  damaged(1s);
  damaged(2s);
  answered(read_, kAnswer, 2600ms, 10ms, 2510ms);
  damaged(3s);
  damaged(4s);
  EXPECT_EQ(health_.state(), DeviceState::answering);
  damaged(5s);
  EXPECT_EQ(health_.state(), DeviceState::damaged);
  EXPECT_EQ(health_.state_since(), at(5s));
  answered(read_, kAnswer, 6100ms, 10ms, 6010ms);
  EXPECT_EQ(health_.state(), DeviceState::answering);
}

TEST_F(Health, ADamagedAnswerBringsNoDeviceBack) {
  for (const auto due : {1s, 2s, 3s}) {
    unanswered(read_, due);
  }
  health_.note_damaged(read_, at(4s), at(3950ms));
  EXPECT_EQ(health_.state(), DeviceState::offline);
}

// Requests to this address are still answered at once.
TEST_F(Health, OfAnotherDeviceOnlyThatTheAddressIsOfflineIsShown) {
  unanswered(read_, 1s);
  health_.forget_shown();
  EXPECT_EQ(health_.state(), DeviceState::not_asked);
  EXPECT_EQ(health_.state_since(), Instant::min());
  EXPECT_FALSE(may_be_asked(1100ms));  // what is owed may still come
  unanswered(read_, 2s);
  EXPECT_TRUE(unanswered(read_, 3s));  // the row goes on
  health_.forget_shown();
  EXPECT_EQ(health_.state(), DeviceState::offline);
}

TEST_F(Health, ADeviceThatAnswersLateIsAnswering) {
  unanswered(read_, 100ms);
  EXPECT_EQ(health_.state(), DeviceState::not_answering);
  ASSERT_TRUE(health_.note_unexpected(kAnswer, at(150ms), timing_));
  EXPECT_EQ(health_.state(), DeviceState::answering);
}

TEST_F(Health, WhatWasAskedBeforeTheLastAnswerChangesNothing) {
  answered(read_, kAnswer, 1s, 10ms, 950ms);
  unanswered(write_, 900ms);  // sent before
  EXPECT_EQ(health_.state(), DeviceState::answering);
}

TEST_F(Health, AStateBeganWhenItChanged) {
  EXPECT_EQ(health_.state_since(), Instant::min());
  answered(read_, kAnswer, 1s, 10ms, 950ms);
  answered(read_, kAnswer, 2s, 10ms, 1950ms);
  EXPECT_EQ(health_.state_since(), at(950ms));
  unanswered(read_, 3s);
  unanswered(read_, 4s);
  EXPECT_EQ(health_.state_since(), at(3s));
  unanswered(read_, 5s);
  unanswered(read_, 6s);
  EXPECT_EQ(health_.state(), DeviceState::offline);
  EXPECT_EQ(health_.state_since(), at(5s));
  answered(read_, kAnswer, 7s, 10ms, 6950ms);
  EXPECT_EQ(health_.state_since(), at(6950ms));
}

TEST_F(Health, AStateBeganWithALateOrDamagedAnswerToo) {
  health_.note_damaged(read_, at(100ms), at(50ms));
  health_.note_damaged(read_, at(200ms), at(150ms));
  EXPECT_EQ(health_.state_since(), at(50ms));
  ASSERT_TRUE(health_.note_unexpected(kAnswer, at(220ms), timing_));
  EXPECT_EQ(health_.state_since(), at(220ms));
}

/// Stops to a drive that is switched off for a minute.
TEST_F(Health, NothingIsLaterThanQuarantineMax) {
  timing_.quarantine_max = 1s;
  for (auto at = 100ms; at <= 60s; at += 150ms) {
    health_.note_asked(this->at(at - 100ms), timing_);
    unanswered(write_, at);
  }
  health_.note_asked(at(60050ms), timing_);
  answered(write_, unhex("06 0000 0001"), 60150ms, 10ms, 60070ms);
  const auto late = health_.note_unexpected(unhex("06 0000 0001"), at(60200ms), timing_);
  ASSERT_TRUE(late);
  EXPECT_LE(late->lateness, 1200ms);
}

}  // namespace
}  // namespace mbgate::test
