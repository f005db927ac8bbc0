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

// Its bytes came one by one; the last of them looks like the beginning of the answer.
TEST_F(RtuPausingFrame, WhatComesSlowlyDoesNotPause) {
  framer_.set_slack(5ms);
  expect("03 001E 0002");
  for (const auto* byte : {"02", "03", "04", "00", "01"}) {
    add(byte);
    now_ += 1900us;
  }
  now_ += 1ms;
  EXPECT_EQ(add("0D 40 9D 93"), Verdict::none);
  const auto unsolicited = framer_.take_unsolicited();
  ASSERT_TRUE(unsolicited);
  EXPECT_EQ(unsolicited->address, 2);
  EXPECT_EQ(unsolicited->pause, Duration{0});
}

// The answer to it would be over with the eighth byte.
TEST_F(RtuPausingFrame, OfAnotherClientsWriteThePiecesArePutTogether) {
  framer_.listen();
  add("02 10 00 00 00 02 04 00 01");
  after(21ms);
  add("00 02 2C EA");
  const auto frame = framer_.take_unsolicited();
  ASSERT_TRUE(frame);
  EXPECT_TRUE(frame->is_request);
  EXPECT_EQ(frame->address, 2);
  EXPECT_EQ(frame->pause, 21ms);
}

}  // namespace
}  // namespace mbgate::test
