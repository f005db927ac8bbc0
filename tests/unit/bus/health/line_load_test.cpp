// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "bus/health/line_diagnosis.hpp"

namespace mbgate::bus {
namespace {

using namespace std::chrono_literals;

class LoadOfALine : public testing::Test {
 protected:
  /// One transmission of that length, with the silence after it, and a pause.
  void transmit(Duration busy, Duration pause) {
    load_.note(true, now_, now_);
    now_ += busy - 2ms;
    load_.note(false, now_, now_ + 2ms);
    now_ += pause + 2ms;
  }

  LineLoad load_;
  Instant now_{100s};
};

TEST_F(LoadOfALine, IsNoneBeforeTheFirstTransmission) { EXPECT_EQ(load_.percent(now_), 0U); }

TEST_F(LoadOfALine, CountsFromTheFirstTransmissionOn) {
  load_.note(true, now_, now_);
  EXPECT_EQ(load_.percent(now_), 0U);
  transmit(250ms, 750ms);
  EXPECT_EQ(load_.percent(now_), 25U);
  load_.note(true, now_, now_);
  EXPECT_EQ(load_.percent(now_ + 1s), 62U);  // it still runs
}

TEST_F(LoadOfALine, CountsWhatLastsOverTheEndOfAWindowOnce) {
  transmit(1s, 7s);
  transmit(4s, 16s);  // of which 2 s lie in the next window
  EXPECT_EQ(load_.total(now_), 5s);
  transmit(1s, 9s);
  load_.note(true, now_, now_);
  EXPECT_EQ(load_.percent(now_ + 11s), 20U);  // 2 of 10 s
}

TEST_F(LoadOfALine, CountsNoTimeTwiceIfTheLineIsUsedEarlierThanWasExpected) {
  for (int at = 0; at < 100; ++at) {
    load_.note(true, now_, now_);
    now_ += 1ms;
    load_.note(false, now_, now_ + 50ms);
    now_ += 4ms;
  }
  EXPECT_EQ(load_.total(now_), 99 * 5ms + 51ms);
  load_.note(true, now_ - 4ms, now_);
  load_.note(false, now_ - 3ms, now_);
  EXPECT_EQ(load_.total(now_), 99 * 5ms + 51ms) << "within the time that counts already";
}

TEST_F(LoadOfALine, IsThatOfTheLastTenSecondsThatAreOver) {
  for (int at = 0; at < 200; ++at) {
    transmit(50ms, 50ms);
  }
  EXPECT_EQ(load_.percent(now_), 50U);
  for (int at = 0; at < 100; ++at) {
    transmit(100ms, 0ms);
  }
  EXPECT_EQ(load_.percent(now_), 100U);
}

TEST_F(LoadOfALine, FadesWhenNobodyAsksAnyMore) {
  for (int at = 0; at < 200; ++at) {
    transmit(50ms, 50ms);
  }
  EXPECT_EQ(load_.percent(now_ + 10s), 0U);
  EXPECT_EQ(load_.percent(now_ + 1000h), 0U);
  now_ += 1000h;
  transmit(50ms, 50ms);
  EXPECT_EQ(load_.percent(now_), 0U);
}

TEST_F(LoadOfALine, HasNoWaitsBeforeTheFirstTransmission) { EXPECT_EQ(load_.waits(now_).all, 0U); }

TEST_F(LoadOfALine, CountsTheRequestsThatWaitedForLong) {
  for (const Duration waited : {0ms, 499ms, 500ms, 3000ms}) {
    load_.note_wait(waited, now_);
    transmit(50ms, 50ms);
  }
  EXPECT_EQ(load_.waits(now_).all, 4U);
  EXPECT_EQ(load_.waits(now_).are_long, 2U);
}

TEST_F(LoadOfALine, HasTheWaitsOfTheLastTenSecondsThatAreOver) {
  for (int at = 0; at < 200; ++at) {
    load_.note_wait(at < 100 ? 600ms : 10ms, now_);
    transmit(50ms, 50ms);
  }
  EXPECT_EQ(load_.waits(now_ - 100ms).are_long, 100U);
  EXPECT_EQ(load_.waits(now_).all, 100U);
  EXPECT_EQ(load_.waits(now_).are_long, 0U);
  EXPECT_EQ(load_.waits(now_ + 10s).all, 0U);
  EXPECT_EQ(load_.waits(now_ + 1000h).all, 0U);
}

}  // namespace
}  // namespace mbgate::bus
