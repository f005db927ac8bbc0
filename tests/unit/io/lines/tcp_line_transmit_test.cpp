// SPDX-License-Identifier: Apache-2.0
// What becomes of a frame that the far end does not take.
#include "tcp_line_rig.hpp"

namespace mbgate::io {
namespace {

/// More than the kernel holds for a far end that does not read.
const std::vector<std::uint8_t> kHugeFrame(1024 * 1024, 0x55);

/// Did the far end see a reset? Everything that came before it is thrown away.
bool was_reset(tcp::socket& peer) {
  std::array<char, 65536> buffer{};
  ssize_t count = 0;
  do {
    count = ::recv(peer.native_handle(), buffer.data(), buffer.size(), MSG_DONTWAIT);
  } while (count > 0);
  return count < 0 && errno == ECONNRESET;
}

TEST_F(TcpLineTest, WritesTheRestAsSoonAsTheFarEndReads) {
  FarEnd far(context_);
  make_line("127.0.0.1", far.port());
  tcp::socket* const peer = connect(far);
  ASSERT_NE(peer, nullptr);
  ASSERT_EQ(line_->transmit(kHugeFrame), std::nullopt);
  std::size_t transmitted = 0;
  ASSERT_TRUE(wait_for([&] {
    transmitted += receive(*peer).size();
    return transmitted >= kHugeFrame.size();
  }));
  EXPECT_EQ(transmitted, kHugeFrame.size());
  EXPECT_EQ(line_->transmit(kFrame), std::nullopt);
  EXPECT_TRUE(wait_for([&] { return receive(*peer) == kFrameText; }));
  EXPECT_TRUE(lost_.empty());
}

TEST_F(TcpLineTest, ThrowsAFrameAwayThatIsNotTakenInTime) {
  FarEnd far(context_);
  make_line("127.0.0.1", far.port());
  tcp::socket* const peer = connect(far);
  ASSERT_NE(peer, nullptr);
  ASSERT_EQ(line_->transmit(kHugeFrame), std::nullopt);
  ASSERT_TRUE(wait_for([&] { return !lost_.empty(); }));
  EXPECT_EQ(lost_, std::vector<std::string>{name_of(far.port()) +
                                            ": the far end does not take a frame in time"});
  EXPECT_TRUE(was_reset(*peer));
}

TEST_F(TcpLineTest, TransmitsNothingBehindAFrameThatIsStuck) {
  FarEnd far(context_);
  make_line("127.0.0.1", far.port());
  tcp::socket* const peer = connect(far);
  ASSERT_NE(peer, nullptr);
  ASSERT_EQ(line_->transmit(kHugeFrame), std::nullopt);
  EXPECT_EQ(line_->transmit(kFrame),
            name_of(far.port()) + ": the far end has not accepted the previous frame");
  context_.poll();
  EXPECT_TRUE(lost_.empty());
  EXPECT_TRUE(was_reset(*peer));
}

TEST_F(TcpLineTest, DoesNotTransmitWhileClosed) {
  make_line("127.0.0.1", 502);
  EXPECT_EQ(line_->transmit(kFrame), std::nullopt);  // it was told that the line is closed
}

}  // namespace
}  // namespace mbgate::io
