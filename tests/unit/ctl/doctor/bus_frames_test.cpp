// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "ctl/serial/heard.hpp"
#include "line_bytes.hpp"

namespace mbgate::ctl {
namespace {

TEST(BusFrames, AreFoundAmongOtherBytes) {
  const auto heard =
      one_after_the_other({{0x00, 0xFF}, rtu_frame(5, kReadPdu), rtu_frame(5, kAnswerPdu), {0x7E}});
  const auto found = find_frames(heard);
  EXPECT_EQ(found.stray, 3U);
  EXPECT_EQ(found.frames, (std::vector<BusFrame>{{2, 8, 5, FrameKind::request},
                                                 {10, 7, 5, FrameKind::response}}));
}

TEST(BusFrames, AreOneThingOrTheOtherWhereAWriteIsAcknowledgedByItself) {
  const auto found = find_frames(rtu_frame(1, {0x06, 0x00, 0x01, 0x00, 0x02}));
  EXPECT_EQ(found.frames, (std::vector<BusFrame>{{0, 8, 1, FrameKind::either}}));
}

TEST(BusFrames, HaveTheRightCrcAndAreWhole) {
  auto frame = rtu_frame(5, kAnswerPdu);
  frame.back() ^= 1U;
  EXPECT_TRUE(find_frames(frame).frames.empty());
  EXPECT_EQ(find_frames(frame).stray, 7U);
  frame.back() ^= 1U;
  frame.pop_back();
  EXPECT_TRUE(find_frames(frame).frames.empty());
  EXPECT_TRUE(find_frames({}).frames.empty());
}

TEST(BusFrames, MayHaveAnAddressBeyondThoseOfTheStandard) {
  EXPECT_EQ(find_frames(rtu_frame(250, kReadPdu)).frames.size(), 1U);
}

}  // namespace
}  // namespace mbgate::ctl
