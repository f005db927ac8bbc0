// SPDX-License-Identifier: Apache-2.0
// When a line is opened again, without a bus.
#include "bus/link_state.hpp"

#include <gtest/gtest.h>

namespace mbgate::test {
namespace {

using bus::Instant;
using bus::LinkState;
using namespace std::chrono_literals;

class Link : public testing::Test {
 protected:
  static bus::BusSettings settings() {
    bus::BusSettings settings;
    settings.reopen_min = 1s;
    settings.reopen_max = 5s;
    return settings;
  }
  void lose(Instant now) { link_.note_lost(settings(), now); }

  LinkState link_{settings().reopen_min};
};

TEST_F(Link, WaitsLongerAfterEachLossUpToItsLimit) {
  Instant now{10s};
  for (const auto delay : {1s, 2s, 4s, 5s, 5s}) {
    lose(now);
    EXPECT_TRUE(link_.is_closed());
    EXPECT_EQ(link_.next_attempt(), now + delay);
    EXPECT_FALSE(link_.take_due(now + delay - 1us));
    now += delay;
    EXPECT_TRUE(link_.take_due(now));
    EXPECT_FALSE(link_.take_due(now)) << "once for each attempt";
  }
}

TEST_F(Link, BeginsAnewOnlyAfterALineThatWorked) {
  lose(Instant{10s});
  link_.note_opened(Instant{11s});
  lose(Instant{12s});
  EXPECT_EQ(link_.next_attempt(), Instant{14s});
  link_.note_opened(Instant{14s});
  lose(Instant{19s});
  EXPECT_EQ(link_.next_attempt(), Instant{20s});
}

TEST_F(Link, KnowsSinceWhenItIsNotOpen) {
  link_.note_opened(Instant{10s});
  lose(Instant{12s});
  EXPECT_EQ(link_.left_at(), Instant{12s});
  lose(Instant{13s});  // an attempt has failed
  EXPECT_EQ(link_.left_at(), Instant{12s});
}

TEST_F(Link, RestsUntilItIsWanted) {
  link_.note_opened(Instant{10s});
  link_.rest(settings(), true, Instant{10s});
  EXPECT_TRUE(link_.is_resting() && link_.serves() && !link_.is_open());
  EXPECT_EQ(link_.next_attempt(), std::nullopt);
  link_.wake(Instant{10s});
  EXPECT_TRUE(link_.serves() && !link_.is_resting());
  link_.note_opened(Instant{11s});
  EXPECT_TRUE(link_.is_open());
}

}  // namespace
}  // namespace mbgate::test
