// SPDX-License-Identifier: Apache-2.0
// Devices that go offline and come back.
#include "health_rig.hpp"

namespace mbgate::test {
namespace {

TEST_F(Health, ADeviceGoesOfflineAndComesBack) {
  EXPECT_FALSE(unanswered(read_, 100ms));
  EXPECT_FALSE(unanswered(read_, 200ms));
  EXPECT_TRUE(unanswered(read_, 300ms));
  EXPECT_TRUE(health_.is_offline());
  EXPECT_FALSE(unanswered(read_, 400ms));
  EXPECT_TRUE(answered(read_, kAnswer, 500ms, 50ms));
  EXPECT_FALSE(health_.is_offline());
  EXPECT_FALSE(answered(read_, kAnswer, 600ms, 50ms));
}

TEST_F(Health, AnyFrameBringsItBack) {
  timing_.offline_after = 1;
  EXPECT_TRUE(unanswered(read_, 100ms));
  EXPECT_TRUE(health_.note_heard(at(150ms)));
  EXPECT_FALSE(health_.is_offline());
}

TEST_F(Health, ALateAnswerIsOneMoreThatItIsThere) {
  timing_.offline_after = 2;
  unanswered(read_, 100ms);
  EXPECT_TRUE(unanswered(read_, 210ms));
  EXPECT_TRUE(health_.note_heard(at(220ms)));
  EXPECT_FALSE(unanswered(read_, 500ms));  // the first in a row
  EXPECT_TRUE(unanswered(read_, 900ms));
}

TEST_F(Health, OfflineCanBeTurnedOff) {
  timing_.offline_after = 0;
  for (int times = 0; times < 100; ++times) {
    EXPECT_FALSE(unanswered(read_, 100ms));
  }
}

TEST_F(Health, ADeviceIsInTheStateOfItsLastRequest) {
  EXPECT_EQ(health_.state(), DeviceState::not_asked);
  health_.note_damaged(at(50ms));
  EXPECT_EQ(health_.state(), DeviceState::damaged);
  unanswered(read_, 500ms);
  EXPECT_EQ(health_.state(), DeviceState::not_answering);
  health_.note_damaged(at(750ms));
  EXPECT_EQ(health_.state(), DeviceState::damaged);
  answered(read_, kAnswer, 1100ms, 10ms);
  health_.note_damaged(at(1150ms));
  EXPECT_EQ(health_.state(), DeviceState::answering);
  for (const auto due : {2s, 3s, 4s}) {
    unanswered(read_, due);
  }
  EXPECT_EQ(health_.state(), DeviceState::offline);
}

TEST_F(Health, ADeviceThatAnswersIsDamagedAfterThreeInARow) {
  const auto damaged = [this](bus::Duration now) { health_.note_damaged(at(now)); };
  answered(read_, kAnswer, 100ms, 50ms);
  damaged(1s);
  damaged(2s);
  answered(read_, kAnswer, 2600ms, 10ms);
  damaged(3s);
  damaged(4s);
  EXPECT_EQ(health_.state(), DeviceState::answering);
  damaged(5s);
  EXPECT_EQ(health_.state(), DeviceState::damaged);
  EXPECT_EQ(health_.state_since(), at(5s));
  answered(read_, kAnswer, 6100ms, 10ms);
  EXPECT_EQ(health_.state(), DeviceState::answering);
}

TEST_F(Health, ADamagedAnswerBringsNoDeviceBack) {
  for (const auto due : {1s, 2s, 3s}) {
    unanswered(read_, due);
  }
  health_.note_damaged(at(3950ms));
  EXPECT_EQ(health_.state(), DeviceState::offline);
}

// Requests to this address are still answered at once.
TEST_F(Health, OfAnotherDeviceOnlyThatTheAddressIsOfflineIsShown) {
  unanswered(read_, 1s);
  health_.forget_shown();
  EXPECT_EQ(health_.state(), DeviceState::not_asked);
  EXPECT_EQ(health_.state_since(), Instant::min());
  unanswered(read_, 2s);
  EXPECT_TRUE(unanswered(read_, 3s));  // the row goes on
  health_.forget_shown();
  EXPECT_EQ(health_.state(), DeviceState::offline);
}

TEST_F(Health, WhatWasAskedBeforeTheLastAnswerChangesNothing) {
  answered(read_, kAnswer, 1s, 50ms);
  unanswered(write_, 900ms);  // sent before
  EXPECT_EQ(health_.state(), DeviceState::answering);
}

TEST_F(Health, AStateBeganWhenItChanged) {
  EXPECT_EQ(health_.state_since(), Instant::min());
  answered(read_, kAnswer, 1s, 50ms);
  answered(read_, kAnswer, 2s, 50ms);
  EXPECT_EQ(health_.state_since(), at(950ms));
  unanswered(read_, 3s);
  unanswered(read_, 4s);
  EXPECT_EQ(health_.state_since(), at(3s));
  unanswered(read_, 5s);
  unanswered(read_, 6s);
  EXPECT_EQ(health_.state(), DeviceState::offline);
  EXPECT_EQ(health_.state_since(), at(5s));
  answered(read_, kAnswer, 7s, 50ms);
  EXPECT_EQ(health_.state_since(), at(6950ms));
}

TEST_F(Health, AStateBeganWithALateOrDamagedAnswerToo) {
  health_.note_damaged(at(50ms));
  health_.note_damaged(at(150ms));
  EXPECT_EQ(health_.state_since(), at(50ms));
  EXPECT_FALSE(health_.note_heard(at(220ms)));
  EXPECT_EQ(health_.state_since(), at(220ms));
}

}  // namespace
}  // namespace mbgate::test
