// SPDX-License-Identifier: Apache-2.0
// The pauses between the pieces of a frame that nobody waits for.
#include "rtu_framer_rig.hpp"

namespace mbgate::test {
namespace {

class RtuPausingFrame : public RtuRig {};

TEST_F(RtuPausingFrame, OfAFrameThatPausesForLongerThePauseIsTold) {
  framer_.listen();
  add("01 03 04 00");
  after(21ms);
  add("03 0D 40 0F 53");
  const auto frame = framer_.take_unsolicited();
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->pause, 21ms);
}

TEST_F(RtuPausingFrame, WhatComesOnAnotherConnectionIsNoRestOfIt) {
  framer_.listen();
  add("01 03 04 00");
  framer_.forget();
  add("03 0D 40 0F 53");
  EXPECT_FALSE(framer_.take_unsolicited());
}

}  // namespace
}  // namespace mbgate::test
