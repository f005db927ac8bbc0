// SPDX-License-Identifier: Apache-2.0
#include "bus/serial/line_silence.hpp"

#include <gtest/gtest.h>

namespace mbgate::bus {
namespace {

using namespace std::chrono_literals;

constexpr Duration kEightBytes = 4583334ns;  // 88 bits at 19200 baud, rounded up

class LineSilenceTest : public testing::Test {
 protected:
  static BusSettings settings() {
    BusSettings settings;
    settings.frame_gap = 2ms;
    settings.turnaround = 100ms;
    settings.settle = 30ms;
    return settings;
  }
  static Instant at(Duration time) { return Instant{} + time; }
  LineSilenceTest() { silence_.open(at(0ms), at(200ms)); }

  BusSettings settings_ = settings();
  LineSilence silence_{settings_};
};

TEST_F(LineSilenceTest, ListensFirstToANewLineForAllButStops) {
  EXPECT_EQ(silence_.ready_at(0ms), at(200ms));
  EXPECT_EQ(silence_.ready_for_stop_at(), at(2ms));
  EXPECT_EQ(silence_.possible_at(), at(0ms));
  EXPECT_TRUE(silence_.is_listening(at(199ms)));
  EXPECT_FALSE(silence_.is_listening(at(200ms)));
}

TEST_F(LineSilenceTest, CountsFromTheLastByteInEitherDirection) {
  silence_.note_frame(8, at(1s));
  const Instant left = at(1s + kEightBytes);
  EXPECT_EQ(silence_.emission_ends(), left);
  EXPECT_EQ(silence_.possible_at(), left);
  EXPECT_EQ(silence_.ready_at(0ms), left + 2ms);
  EXPECT_EQ(silence_.ready_at(5ms), left + 7ms);
  silence_.note_bytes(at(1001ms));  // its echo
  EXPECT_EQ(silence_.quiet_since(), left);
  silence_.note_bytes(at(1050ms));
  EXPECT_EQ(silence_.quiet_since(), at(1050ms));
  EXPECT_EQ(silence_.ready_for_stop_at(), at(1052ms));
  EXPECT_FALSE(silence_.is_silent(at(1051ms)));
  EXPECT_TRUE(silence_.is_silent(at(1052ms)));
}

TEST_F(LineSilenceTest, SaysSinceWhenBytesFollowEachOther) {
  silence_.note_bytes(at(10ms));
  silence_.note_bytes(at(12ms));
  EXPECT_EQ(silence_.busy_since(), at(10ms));
  silence_.note_bytes(at(15ms));
  EXPECT_EQ(silence_.busy_since(), at(15ms));
}

// No stop may go in such a pause either.
TEST_F(LineSilenceTest, APauseInAFrameIsNoSilence) {
  silence_.note_bytes(at(10ms));
  silence_.note_pause(true);
  silence_.note_bytes(at(25ms));
  EXPECT_EQ(silence_.busy_since(), at(10ms));
  silence_.note_bytes(at(46ms));
  EXPECT_EQ(silence_.busy_since(), at(46ms));
}

TEST_F(LineSilenceTest, ThatFrameDoesNotGoOnBehindAnOwnOneNorOnANewLine) {
  silence_.note_bytes(at(10ms));
  silence_.note_pause(true);
  silence_.note_frame(8, at(1s));
  EXPECT_EQ(silence_.ready_for_stop_at(), at(1s + kEightBytes + 2ms));
  silence_.note_pause(true);
  silence_.open(at(2s), at(2s));
  EXPECT_EQ(silence_.ready_for_stop_at(), at(2002ms));
}

TEST_F(LineSilenceTest, WaitsForTheTurnaroundDelayOfABroadcastThoughTheLineIsReopened) {
  silence_.note_frame(8, at(1s));
  silence_.note_broadcast();
  const Instant over = at(1s + kEightBytes + 100ms);
  EXPECT_EQ(silence_.ready_at(0ms), over);
  EXPECT_EQ(silence_.ready_for_stop_at(), over);
  EXPECT_EQ(silence_.possible_at(), over);
  EXPECT_TRUE(silence_.is_in_turnaround(over - 1ns));
  EXPECT_FALSE(silence_.is_in_turnaround(over));
  silence_.open(at(1050ms), at(1050ms));
  EXPECT_EQ(silence_.ready_for_stop_at(), over);
}

TEST_F(LineSilenceTest, SettlesWhereAnAnswerIsMissingForAllButStops) {
  silence_.note_unanswered(at(1s));
  EXPECT_EQ(silence_.ready_at(0ms), at(1030ms));
  EXPECT_EQ(silence_.ready_for_stop_at(), at(2ms));
  silence_.open(at(1010ms), at(1010ms));  // another line, on which none is missing
  EXPECT_EQ(silence_.ready_at(0ms), at(1012ms));
}

TEST_F(LineSilenceTest, TakesOtherTimes) {
  settings_.frame_gap.reset();
  settings_.turnaround = 50ms;
  settings_.settle = 70ms;
  silence_.note_pause(false);
  EXPECT_EQ(silence_.ready_for_stop_at(), at(2005209ns));  // 38.5 bits, rounded up
  silence_.note_frame(8, at(500ms));
  silence_.note_broadcast();
  EXPECT_EQ(silence_.ready_for_stop_at(), at(550ms + kEightBytes));
  silence_.open(at(1s), at(1s));
  EXPECT_FALSE(silence_.is_listening(at(1s)));
  silence_.note_unanswered(at(2s));
  EXPECT_EQ(silence_.ready_at(0ms), at(2070ms));
}

}  // namespace
}  // namespace mbgate::bus
