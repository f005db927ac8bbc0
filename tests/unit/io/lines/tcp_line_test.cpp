// SPDX-License-Identifier: Apache-2.0
#include "io/lines/tcp_line.hpp"

#include <netinet/tcp.h>

#include <boost/asio/write.hpp>

#include "tcp_line_rig.hpp"

namespace mbgate::io {
namespace {

TEST_F(TcpLineTest, CarriesBytesBothWays) {
  FarEnd far(context_);
  make_line("127.0.0.1", far.port());
  tcp::socket* const peer = connect(far);
  ASSERT_NE(peer, nullptr);
  EXPECT_EQ(warnings_, std::vector<std::string>{});
  ASSERT_EQ(line_->transmit(kFrame), std::nullopt);
  std::string transmitted;
  ASSERT_TRUE(wait_for([&] {
    transmitted += receive(*peer);
    return transmitted.size() >= kFrame.size();
  }));
  EXPECT_EQ(transmitted, kFrameText);
  boost::asio::write(*peer, boost::asio::buffer(kFrame));
  ASSERT_TRUE(wait_for([&] { return received_.size() >= kFrame.size(); }));
  EXPECT_EQ(received_, kFrameText);
  EXPECT_TRUE(lost_.empty());
}

// What is at the beginning may be an answer: a framer drops what it has no room for, all of it.
TEST_F(TcpLineTest, HandsOverNoMoreAtOnceThanAFramerHasRoomFor) {
  FarEnd far(context_);
  make_line("127.0.0.1", far.port());
  tcp::socket* const peer = connect(far);
  ASSERT_NE(peer, nullptr);
  const std::string noise(3000, '\xFF');
  boost::asio::write(*peer, boost::asio::buffer(noise));
  ASSERT_TRUE(wait_for([&] { return received_.size() >= noise.size(); }));
  EXPECT_EQ(received_, noise);
  EXPECT_LE(longest_piece_, 512U) << "half of what a framer has room for";
}

TEST_F(TcpLineTest, ReportsNothingFromWithinOpen) {
  FarEnd far(context_);
  make_line("127.0.0.1", far.port());
  line_->open();
  line_->open();
  EXPECT_EQ(opened_, 0);
  ASSERT_TRUE(wait_for([&] { return opened_ > 0; }));
  line_->open();
  context_.poll();
  EXPECT_EQ(opened_, 1);
  far.accept();
  EXPECT_FALSE(far.has_waiting());
}

TEST_F(TcpLineTest, SaysThatItWasRefused) {
  FarEnd far(context_);
  far.stop_listening();
  make_line("127.0.0.1", far.port());
  line_->open();
  EXPECT_TRUE(lost_.empty());
  ASSERT_TRUE(wait_for([&] { return !lost_.empty(); }));
  EXPECT_EQ(lost_, std::vector<std::string>{"cannot connect to " + name_of(far.port()) +
                                            ": Connection refused"});
}

TEST_F(TcpLineTest, NoticesThatTheFarEndCloses) {
  FarEnd far(context_);
  make_line("127.0.0.1", far.port());
  tcp::socket* const peer = connect(far);
  ASSERT_NE(peer, nullptr);
  boost::asio::write(*peer, boost::asio::buffer(kFrame));
  peer->close();
  ASSERT_TRUE(wait_for([&] { return !closed_.empty(); }));
  EXPECT_EQ(received_, kFrameText);
  EXPECT_EQ(closed_, std::vector<std::string>{name_of(far.port()) +
                                              ": the far end has closed the connection"});
  EXPECT_TRUE(lost_.empty());
  EXPECT_EQ(line_->transmit(kFrame), std::nullopt);  // whoever wants that was told already
}

TEST_F(TcpLineTest, NoticesAReset) {
  FarEnd far(context_);
  make_line("127.0.0.1", far.port());
  tcp::socket* const peer = connect(far);
  ASSERT_NE(peer, nullptr);
  peer->set_option(tcp::socket::linger(true, 0));
  peer->close();
  ASSERT_TRUE(wait_for([&] { return !closed_.empty(); }));
  EXPECT_EQ(closed_, std::vector<std::string>{name_of(far.port()) + ": Connection reset by peer"});
}

TEST_F(TcpLineTest, NoticesWhileItSendsThatTheFarEndHasClosed) {
  FarEnd far(context_);
  make_line("127.0.0.1", far.port());
  tcp::socket* const peer = connect(far);
  ASSERT_NE(peer, nullptr);
  peer->set_option(tcp::socket::linger(true, 0));
  peer->close();
  EXPECT_EQ(line_->transmit(kFrame), std::nullopt);
  ASSERT_TRUE(wait_for([&] { return !closed_.empty(); }));
  EXPECT_TRUE(lost_.empty());
}

/// The descriptor of the line's connection to the port.
int descriptor_to(std::uint16_t port) {
  for (int descriptor = 0; descriptor < 1024; ++descriptor) {
    sockaddr_in peer{};
    socklen_t size = sizeof peer;
    if (::getpeername(descriptor, reinterpret_cast<sockaddr*>(&peer), &size) == 0 &&
        peer.sin_family == AF_INET && ntohs(peer.sin_port) == port) {
      return descriptor;
    }
  }
  return -1;
}

TEST_F(TcpLineTest, TakesItsTimesFromTheSettings) {
  FarEnd far(context_);
  times_.acknowledge_timeout = std::chrono::milliseconds(700);
  times_.idle_probe = std::chrono::seconds(20);
  make_line("127.0.0.1", far.port());
  ASSERT_NE(connect(far), nullptr);
  EXPECT_TRUE(warnings_.empty());
  const auto option = [descriptor = descriptor_to(far.port())](int number) {
    int value = 0;
    socklen_t size = sizeof value;
    EXPECT_EQ(::getsockopt(descriptor, IPPROTO_TCP, number, &value, &size), 0);
    return value;
  };
  EXPECT_EQ(option(TCP_USER_TIMEOUT), 700);
  EXPECT_EQ(option(TCP_KEEPIDLE) + option(TCP_KEEPINTVL), 20);
}

TEST_F(TcpLineTest, KeepsUnreadBytesFromTheNextConnection) {
  FarEnd far(context_);
  make_line("127.0.0.1", far.port());
  tcp::socket* const first = connect(far);
  ASSERT_NE(first, nullptr);
  boost::asio::write(*first, boost::asio::buffer(kFrame));
  line_->close();
  tcp::socket* const second = connect(far);
  ASSERT_NE(second, nullptr);
  boost::asio::write(*second, boost::asio::buffer(std::string("new")));
  ASSERT_TRUE(wait_for([&] { return !received_.empty(); }));
  EXPECT_EQ(received_, "new");
  EXPECT_TRUE(lost_.empty());
}

TEST_F(TcpLineTest, OpensAgainAfterALoss) {
  FarEnd far(context_);
  make_line("127.0.0.1", far.port());
  tcp::socket* const first = connect(far);
  ASSERT_NE(first, nullptr);
  first->close();
  ASSERT_TRUE(wait_for([&] { return closed_.size() == 1; }));
  tcp::socket* const second = connect(far);
  ASSERT_NE(second, nullptr);
  ASSERT_EQ(line_->transmit(kFrame), std::nullopt);
  EXPECT_TRUE(wait_for([&] { return receive(*second) == kFrameText; }));
}

TEST_F(TcpLineTest, ReportsNothingOnceItWasClosedWhileConnecting) {
  FarEnd far(context_);
  make_line("127.0.0.1", far.port());
  line_->open();
  line_->close();
  context_.poll();
  EXPECT_EQ(opened_, 0);
  EXPECT_TRUE(lost_.empty());
  tcp::socket* const peer = connect(far);
  ASSERT_NE(peer, nullptr);
  EXPECT_EQ(opened_, 1);
}

TEST_F(TcpLineTest, GivesUpOnAFarEndThatDoesNotAnswer) {
  FarEnd far(context_, 0);
  // The kernel answers no further connection than these until somebody accepts them.
  const tcp::endpoint address(boost::asio::ip::address_v4::loopback(), far.port());
  std::list<tcp::socket> filling;
  for (int i = 0; i < 4; ++i) {
    filling.emplace_back(context_, tcp::v4()).native_non_blocking(true);
    const int connected = ::connect(filling.back().native_handle(), address.data(),
                                    static_cast<socklen_t>(address.size()));
    ASSERT_TRUE(connected == 0 || errno == EINPROGRESS);
  }
  times_.connect_timeout = std::chrono::milliseconds(300);
  make_line("127.0.0.1", far.port());
  line_->open();
  ASSERT_TRUE(wait_for([&] { return !lost_.empty(); }));
  EXPECT_EQ(lost_, std::vector<std::string>{"cannot connect to " + name_of(far.port()) +
                                            ": Connection timed out"});
}

TEST_F(TcpLineTest, LooksUpANameAndTriesItsAddresses) {
  FarEnd far(context_);
  make_line(kName, far.port());
  tcp::socket* const peer = connect(far);
  ASSERT_NE(peer, nullptr);
  ASSERT_EQ(line_->transmit(kFrame), std::nullopt);
  EXPECT_TRUE(wait_for([&] { return receive(*peer) == kFrameText; }));
}

TEST_F(TcpLineTest, NamesEachAddressOfANameThatWasTried) {
  FarEnd far(context_);
  far.stop_listening();
  const bus::Endpoint remote{kName, far.port()};
  make_line(remote.host, remote.port);
  line_->open();
  ASSERT_TRUE(wait_for([&] { return !lost_.empty(); }));
  const auto addresses = resolve(remote);
  ASSERT_TRUE(addresses);
  std::string expected;
  for (const auto& address : *addresses) {
    expected += expected.empty() ? "" : "; ";
    expected += address.address().to_string() + ": Connection refused";
  }
  EXPECT_EQ(lost_[0], "cannot connect to " + to_text(remote) + ": " + expected);
}

TEST_F(TcpLineTest, SaysThatANameDoesNotExist) {
  const std::string name = "no host";  // not a name: no name server is asked
  make_line(name, 502);
  line_->open();
  EXPECT_TRUE(lost_.empty());
  ASSERT_TRUE(wait_for([&] { return !lost_.empty(); }));
  EXPECT_EQ(lost_[0], "cannot connect to tcp://" + name + ":502: " + resolve({name, 502}).error());
}

TEST_F(TcpLineTest, ForgetsANameLookedUpForNobody) {
  FarEnd far(context_);
  make_line(kName, far.port());
  line_->open();
  line_->close();
  ASSERT_NE(connect(far), nullptr);
  context_.poll();
  EXPECT_EQ(opened_, 1);
  EXPECT_TRUE(lost_.empty());
  EXPECT_FALSE(far.has_waiting());
}

}  // namespace
}  // namespace mbgate::io
