// SPDX-License-Identifier: Apache-2.0
// What proves that a line has an echo, and what does not; who was heard.
#include "lone_echo.hpp"

namespace mbgate::test {
namespace {

TEST_F(Echo, ThatNoAnswerFollowsProvesNothing) {
  begin(std::nullopt);
  for (const auto* request : {kReadPdu, "10 0000 0001 02 0001"}) {
    send(request);
    const auto frame = modbus::encode_rtu(1, pdu(request));
    EXPECT_EQ(take(hex({frame.data(), frame.size()})), "|");
    send(kReadPdu);
    EXPECT_TRUE(echo_->is_unknown());
  }
  EXPECT_THAT(told(), IsEmpty());
}

TEST_F(Echo, MayBeFoundAgainstReadsThatShowedNone) {
  begin(std::nullopt);
  send(kReadPdu);
  answered("03 02 12 34");
  send(kReadPdu);
  EXPECT_EQ(take(kSentRead), "|");
  answered("03 02 12 34");
  EXPECT_EQ(echo_->noticed(), bus::NoticedEcho::found);
}

TEST_F(Echo, IsUnknownAgainAfterThreeReadsInARowThatLackIt) {
  begin(std::nullopt);
  for (int round = 0; round < 3; ++round) {
    send(kReadPdu);
    EXPECT_EQ(take(kSentRead), "|");
    answered("03 02 12 34");
    EXPECT_TRUE(echo_->was_shown());
    send(kReadPdu);
    take("01 86");  // it differs
    for (int reads = 0; reads < 3; ++reads) {
      EXPECT_TRUE(echo_->was_shown());
      send("10 0000 0001 02 0001");
      answered("10 0000 0001");  // a write says nothing
      send(kReadPdu);
      answered("03 02 12 34");
    }
    EXPECT_FALSE(echo_->was_shown());
  }
}

TEST_F(Echo, ADeviceIsHeardByWhatIsNoRepetition) {
  begin(std::nullopt);
  send(kWritePdu);
  EXPECT_FALSE(echo_->has_heard_device());
  answered(kWritePdu);
  EXPECT_FALSE(echo_->has_heard_device());
  answered("86 02");
  EXPECT_TRUE(echo_->has_heard_device());
  echo_->open();
  send(kWritePdu);
  EXPECT_FALSE(echo_->has_heard_device());
}

}  // namespace
}  // namespace mbgate::test
