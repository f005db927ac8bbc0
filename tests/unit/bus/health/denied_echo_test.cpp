// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "bus/health/line_diagnosis.hpp"

namespace mbgate::bus {
namespace {

using namespace std::chrono_literals;

class DeniedEchoTest : public testing::Test {
 protected:
  /// A transmission of which the own request is heard. True: that is to be told.
  bool hear(Duration time) {
    const bool is_reportable = echo_.note_heard(Instant{} + time);
    echo_.note_ended(true);
    return is_reportable;
  }

  DeniedEcho echo_;
};

TEST_F(DeniedEchoTest, IsToldOnceWhenTwoRequestsInARowWereHeard) {
  EXPECT_FALSE(hear(1s));
  EXPECT_FALSE(echo_.is_found());
  EXPECT_TRUE(hear(2s));
  EXPECT_TRUE(echo_.is_found());
  EXPECT_FALSE(hear(3s));
  EXPECT_TRUE(echo_.is_found());
}

TEST_F(DeniedEchoTest, CountsARequestOnceHoweverOftenItIsHeard) {
  EXPECT_FALSE(echo_.note_heard(Instant{1s}));
  EXPECT_FALSE(echo_.note_heard(Instant{1s}));
  EXPECT_FALSE(echo_.is_found());
}

TEST_F(DeniedEchoTest, IsProvenByTwoWithinAMinuteOnly) {
  EXPECT_FALSE(hear(0s));
  EXPECT_FALSE(hear(61s));
  EXPECT_TRUE(hear(121s));
}

TEST_F(DeniedEchoTest, IsOverWithAReadThatIsAnsweredWithoutOne) {
  hear(1s);
  echo_.note_ended(false);
  EXPECT_TRUE(hear(2s));
  echo_.note_ended(true);
  EXPECT_FALSE(echo_.is_found());
  EXPECT_FALSE(hear(3s));
  EXPECT_FALSE(hear(4s)) << "it was told before";
  EXPECT_TRUE(echo_.is_found());
}

TEST_F(DeniedEchoTest, IsToldAgainOfAnotherAdapter) {
  hear(1s);
  EXPECT_TRUE(hear(2s));
  echo_ = {};
  EXPECT_FALSE(echo_.is_found());
  EXPECT_FALSE(hear(3s));
  EXPECT_TRUE(hear(4s));
}

}  // namespace
}  // namespace mbgate::bus
