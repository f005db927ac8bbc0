// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <string>

#include "sim/wire/request_framer.hpp"

namespace mbgate::test {
namespace {

using namespace std::chrono_literals;
using bus::Instant;
using testing::ElementsAre;
using testing::IsEmpty;

class AsciiCharacters : public testing::Test {
 protected:
  /// What the characters end, each taking 1 ms, one after the other.
  std::vector<std::string> feed(std::string_view characters) {
    std::vector<std::string> ended;
    for (const char character : characters) {
      const auto frame = framer_.feed(static_cast<std::uint8_t>(character), at_, at_ + 1ms);
      at_ += 1ms;
      if (frame) {
        ended.emplace_back(frame->bytes.begin(), frame->bytes.end());
        begin_ = frame->begin;
        end_ = frame->end;
      }
    }
    return ended;
  }

  sim::AsciiFramer framer_;
  Instant at_{1s};
  Instant begin_{};
  Instant end_{};
};

TEST_F(AsciiCharacters, MakeAFrameFromColonToLineEnd) {
  EXPECT_THAT(feed(":0207F7\r\n"), ElementsAre(":0207F7\r\n"));
  EXPECT_EQ(begin_, Instant(1000ms));
  EXPECT_EQ(end_, Instant(1009ms));
  EXPECT_THAT(feed(":0307F6\r\n:0407F5\r\n"), ElementsAre(":0307F6\r\n", ":0407F5\r\n"));
}

TEST_F(AsciiCharacters, OutsideAFrameAreNoise) {
  EXPECT_THAT(feed("0207F7\r\n\r\n"), IsEmpty());
  EXPECT_THAT(feed(":0207F7\r\n"), ElementsAre(":0207F7\r\n"));
}

TEST_F(AsciiCharacters, BeginAnewWithEveryColon) {
  EXPECT_THAT(feed(":0206:0207F7\r\n"), ElementsAre(":0206", ":0207F7\r\n"));
  EXPECT_EQ(begin_, Instant(1005ms));
}

TEST_F(AsciiCharacters, MayComeUpToASecondApart) {
  EXPECT_THAT(feed(":02"), IsEmpty());
  at_ += 1s;
  EXPECT_THAT(feed("07F7\r\n"), ElementsAre(":0207F7\r\n"));
  EXPECT_THAT(feed(":02"), IsEmpty());
  at_ += 1001ms;
  EXPECT_THAT(feed("07F7\r\n"), ElementsAre(":02"));
  EXPECT_EQ(end_, Instant(2012ms));
  EXPECT_THAT(feed(":0207F7\r\n"), ElementsAre(":0207F7\r\n"));
}

TEST_F(AsciiCharacters, EndAnAttemptThatIsTooLong) {
  const std::string endless(600, '0');
  const auto ended = feed(":" + endless);
  ASSERT_EQ(ended.size(), 1U);
  EXPECT_EQ(ended[0].size(), 514U);
  EXPECT_THAT(feed(":0207F7\r\n"), ElementsAre(":0207F7\r\n"));
}

TEST_F(AsciiCharacters, AreForgottenWhenCleared) {
  EXPECT_THAT(feed(":02"), IsEmpty());
  framer_.clear();
  EXPECT_THAT(feed("07F7\r\n"), IsEmpty());
}

}  // namespace
}  // namespace mbgate::test
