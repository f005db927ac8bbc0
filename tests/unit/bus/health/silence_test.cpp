// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "bus/health/device_health.hpp"

namespace mbgate::test {
namespace {

using namespace std::chrono_literals;

constexpr bus::Instant moment(bus::Duration time) { return bus::Instant{} + time; }

TEST(Silence, CountsTransmissionsAndTheRequestsAmongThem) {
  bus::Silence silence;
  silence.note_unanswered(moment(1s), true);
  silence.note_unanswered(moment(2s), false);
  silence.note_unanswered(moment(3s), true);
  EXPECT_EQ(silence.transmissions(), 3U);
  EXPECT_EQ(silence.requests(), 2U);
  EXPECT_EQ(silence.last_answer(), bus::Instant::min());
}

TEST(Silence, EndsWithADamagedAnswerToo) {
  bus::Silence silence;
  silence.note_answer(moment(1s));
  silence.note_unanswered(moment(2s), true);
  silence.note_damaged(moment(3s));
  EXPECT_EQ(silence.transmissions(), 0U);
  EXPECT_EQ(silence.requests(), 0U);
  EXPECT_EQ(silence.last_answer(), moment(1s));
}

// On a connection answers come in any order.
TEST(Silence, BeginsBehindTheLastThatWasHeard) {
  bus::Silence silence;
  silence.note_answer(moment(2s));
  silence.note_unanswered(moment(1s), true);
  EXPECT_EQ(silence.transmissions(), 0U);
  silence.note_unanswered(moment(2s), true);
  EXPECT_EQ(silence.transmissions(), 1U);
}

}  // namespace
}  // namespace mbgate::test
