// SPDX-License-Identifier: Apache-2.0
// Frames that began before the request was sent, or on another connection.
#include "ascii_framer_rig.hpp"

namespace mbgate::test::ascii_earlier_frame_test {
namespace {

class AsciiEarlierFrame : public AsciiRig {};

constexpr auto kRead = "03 0000 0001";
constexpr std::string_view kAnswer = ":0103021234B4\r\n";

/// It is late: whoever waits for it, or for something else, when its end comes.
TEST_F(AsciiEarlierFrame, IsNoAnswerToTheRequest) {
  for (const bool is_asked : {false, true}) {
    expect(kRead);
    EXPECT_EQ(add(kAnswer.substr(0, 6)), Verdict::none);
    framer_.listen();
    if (is_asked) {
      expect(kRead);
      EXPECT_FALSE(framer_.in_progress());
    }
    EXPECT_EQ(add(kAnswer.substr(6)), Verdict::none);
    EXPECT_TRUE(framer_.take_unsolicited()) << is_asked;
  }
  EXPECT_EQ(add(kAnswer), Verdict::response);
}

TEST_F(AsciiEarlierFrame, IsOverThoughItsLineFeedIsMissing) {
  EXPECT_EQ(add(":0103021234B4\r"), Verdict::none);
  expect(kRead);
  EXPECT_TRUE(framer_.take_unsolicited());
  EXPECT_EQ(after(20ms), Verdict::none);
  EXPECT_EQ(add(kAnswer), Verdict::response);
}

TEST_F(AsciiEarlierFrame, DoesNotGoOnOnAnotherConnection) {
  framer_.listen();
  add(":0103021");
  framer_.forget();
  add("234B4\r\n");
  EXPECT_FALSE(framer_.take_unsolicited());
}

}  // namespace
}  // namespace mbgate::test::ascii_earlier_frame_test
