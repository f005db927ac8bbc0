// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "bus/link_state.hpp"

namespace mbgate::bus {
namespace {

using namespace std::chrono_literals;

constexpr Instant kStart{1h};

class AdapterWatchTest : public testing::Test {
 protected:
  void ask(unsigned requests) {
    for (unsigned i = 0; i < requests; ++i) {
      watch_.note_request();
    }
  }
  bool is_hung(Duration after) const { return watch_.is_hung(settings_, kStart + after); }

  BusSettings settings_;
  AdapterWatch watch_;
};

TEST_F(AdapterWatchTest, NeedsThirtySecondsOfSilenceAndTenRequests) {
  watch_.open(LineKind::uart, kStart);
  ask(9);
  EXPECT_FALSE(is_hung(1h)) << "only nine requests";
  ask(1);
  EXPECT_FALSE(is_hung(29999ms));
  EXPECT_TRUE(is_hung(30s));
  EXPECT_EQ(watch_.silence(kStart + 30s), 30s);
  EXPECT_EQ(watch_.requests(), 10U);
}

TEST_F(AdapterWatchTest, TakesAnyByteForLife) {
  watch_.open(LineKind::adapter, kStart);
  ask(50);
  watch_.note_byte(kStart + 29s);
  ask(9);
  EXPECT_FALSE(is_hung(2min));
  ask(1);
  EXPECT_FALSE(is_hung(58s));
  EXPECT_TRUE(is_hung(59s));
}

TEST_F(AdapterWatchTest, LeavesVirtualLinesAlone) {
  watch_.open(LineKind::virtual_line, kStart);
  ask(1000);
  EXPECT_FALSE(is_hung(1h));
}

TEST_F(AdapterWatchTest, CanBeTurnedOff) {
  settings_.hung_after = 0s;
  watch_.open(LineKind::uart, kStart);
  ask(1000);
  EXPECT_FALSE(is_hung(1h));
}

TEST_F(AdapterWatchTest, ReopensEverLessOftenUpToTenMinutes) {
  Instant now = kStart;
  watch_.open(LineKind::uart, now);
  for (const Duration patience : {30s, 60s, 120s, 240s, 480s, 600s, 600s}) {
    ask(10);
    EXPECT_FALSE(watch_.is_hung(settings_, now + patience - 1ms));
    EXPECT_TRUE(watch_.is_hung(settings_, now + patience));
    now += patience;
    EXPECT_EQ(watch_.note_reopening(), patience == 30s) << "is told once";
    watch_.open(LineKind::uart, now);
  }
}

TEST_F(AdapterWatchTest, BeginsAnewOnceSomethingWasHeard) {
  watch_.open(LineKind::uart, kStart);
  EXPECT_TRUE(watch_.note_reopening());
  EXPECT_FALSE(watch_.note_reopening());
  watch_.open(LineKind::uart, kStart);
  watch_.note_byte(kStart);
  ask(10);
  EXPECT_TRUE(is_hung(30s));
  EXPECT_TRUE(watch_.note_reopening());
}

}  // namespace
}  // namespace mbgate::bus
