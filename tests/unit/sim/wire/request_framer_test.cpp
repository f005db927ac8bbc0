// SPDX-License-Identifier: Apache-2.0
#include "sim/wire/request_framer.hpp"

#include <gtest/gtest.h>

#include "unit/sim/wire/wire_rig.hpp"

namespace mbgate::test {
namespace {

class RequestFraming : public testing::Test {
 protected:
  void feed(std::string_view bytes, Duration at) { framer_.feed(unhex(bytes), Instant(at)); }
  std::string poll(Duration at) {
    const auto frame = framer_.poll(Instant(at));
    begin_ = frame ? frame->begin : Instant{};
    return frame ? hex(frame->bytes) : "nothing";
  }

  sim::RequestFramer framer_{20ms};
  Instant begin_{};
};

TEST_F(RequestFraming, RecognisesAWholeRequestAtOnce) {
  feed(kReadStatus, 5ms);
  EXPECT_EQ(poll(5ms), kReadStatus);
  EXPECT_EQ(begin_, Instant(5ms));
  EXPECT_EQ(poll(5ms), "nothing");
  EXPECT_EQ(framer_.deadline(), std::nullopt);
}

TEST_F(RequestFraming, PutsPartsTogether) {
  const std::string_view write = "0A 10 00 1E 00 02 04 00 00 75 30 70 8F";
  feed(write.substr(0, 14), 1ms);
  EXPECT_EQ(poll(1ms), "nothing");
  feed(write.substr(14), 9ms);
  EXPECT_EQ(poll(9ms), write);
  EXPECT_EQ(begin_, Instant(1ms));
}

TEST_F(RequestFraming, PartsWhatCameTogether) {
  feed(std::string(kReadStatus).append(kReadStatus2), 1ms);
  EXPECT_EQ(poll(1ms), kReadStatus);
  EXPECT_EQ(poll(1ms), kReadStatus2);
  EXPECT_EQ(poll(1ms), "nothing");
}

TEST_F(RequestFraming, KnowsTheBroadcastFunctionsOfTheAic) {
  feed("81 85 00 17 FF 00 22 20", 1ms);
  EXPECT_EQ(poll(1ms), "81 85 00 17 FF 00 22 20");
}

TEST_F(RequestFraming, EndsUnknownFunctionsBySilence) {
  feed("01 46 01 D3 A0", 1ms);
  EXPECT_EQ(poll(20ms), "nothing");
  EXPECT_EQ(framer_.deadline(), Instant(21ms));
  EXPECT_EQ(poll(21ms), "01 46 01 D3 A0");
}

TEST_F(RequestFraming, EndsDamagedFramesBySilence) {
  feed("01 03 00 01 00 01 D5 CB", 1ms);
  EXPECT_EQ(poll(1ms), "nothing");
  EXPECT_EQ(poll(21ms), "01 03 00 01 00 01 D5 CB");
}

TEST_F(RequestFraming, DoesNotCollectNoiseWithoutEnd) {
  framer_.feed(std::vector<std::uint8_t>(513, 0xFF), Instant(1ms));
  EXPECT_EQ(framer_.poll(Instant(1ms))->bytes.size(), 513U);
}

TEST_F(RequestFraming, ForgetsWhenCleared) {
  feed("01 03", 1ms);
  framer_.clear();
  EXPECT_EQ(poll(1s), "nothing");
}

TEST(RequestFrameLength, FollowsTheFunction) {
  const auto length = [](std::string_view prefix) {
    return sim::request_frame_length(unhex(prefix));
  };
  EXPECT_EQ(length("01"), std::nullopt);
  EXPECT_EQ(length("01 07"), 4U);
  EXPECT_EQ(length("01 0F 00 00 00 08 01"), 10U);
  EXPECT_EQ(length("01 10 00 00 00 01"), std::nullopt);
  EXPECT_EQ(length("81 90 14 50 00 02 04"), 13U);
  EXPECT_EQ(length("01 14 07"), 12U);
  EXPECT_EQ(length("01 16"), 10U);
  EXPECT_EQ(length("01 17 00 00 00 01 00 00 00 01 02"), 15U);
  EXPECT_EQ(length("01 18"), 6U);
  EXPECT_EQ(length("01 46"), std::nullopt);
}

}  // namespace
}  // namespace mbgate::test
