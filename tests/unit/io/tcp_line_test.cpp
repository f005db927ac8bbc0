// SPDX-License-Identifier: Apache-2.0
#include "io/tcp_line.hpp"

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>

#include <boost/asio/write.hpp>
#include <list>

#include "run_until.hpp"

namespace mbgate::io {
namespace {

using boost::asio::ip::tcp;

const std::array<std::uint8_t, 4> kFrame{1, 2, 3, 4};
const std::string kFrameText{1, 2, 3, 4};
/// More than the kernel holds for a far end that does not read.
const std::vector<std::uint8_t> kHugeFrame(1024 * 1024, 0x55);

/// The far end: its connections are taken when the test wants it.
class FarEnd {
 public:
  explicit FarEnd(boost::asio::io_context& context, int backlog = 16) : acceptor_(context) {
    acceptor_.open(tcp::v4());
    acceptor_.set_option(tcp::acceptor::reuse_address(true));
    acceptor_.bind({boost::asio::ip::address_v4::loopback(), 0});
    acceptor_.listen(backlog);
    port_ = acceptor_.local_endpoint().port();
  }

  [[nodiscard]] std::uint16_t port() const { return port_; }
  /// Waits for a connection that the line makes.
  tcp::socket& accept() { return peers_.emplace_back(acceptor_.accept()); }
  [[nodiscard]] bool has_waiting() {
    pollfd watched{acceptor_.native_handle(), POLLIN, 0};
    return ::poll(&watched, 1, 0) > 0;
  }
  void stop_listening() { acceptor_.close(); }

 private:
  tcp::acceptor acceptor_;
  std::list<tcp::socket> peers_;
  std::uint16_t port_ = 0;
};

/// What has come, without waiting.
std::string receive(tcp::socket& peer) {
  std::string bytes(65536, '\0');
  const ssize_t count = ::recv(peer.native_handle(), bytes.data(), bytes.size(), MSG_DONTWAIT);
  bytes.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
  return bytes;
}

/// Did the far end see a reset? Everything that came before it is thrown away.
bool was_reset(tcp::socket& peer) {
  std::array<char, 65536> buffer{};
  ssize_t count = 0;
  do {
    count = ::recv(peer.native_handle(), buffer.data(), buffer.size(), MSG_DONTWAIT);
  } while (count > 0);
  return count < 0 && errno == ECONNRESET;
}

class TcpLineTest : public testing::Test, public LineEvents {
 protected:
  void line_opened(drive::BusId /*bus*/, const std::vector<std::string>& warnings) override {
    ++opened_;
    warnings_ = warnings;
  }
  void line_bytes(drive::BusId /*bus*/, modbus::Bytes bytes) override {
    received_.append(bytes.begin(), bytes.end());
  }
  void line_lost(drive::BusId /*bus*/, const std::string& why) override { lost_.push_back(why); }

  void make_line(const std::string& host, std::uint16_t port) {
    line_.emplace(LineContext{context_, blocking_, *this}, drive::BusId{0},
                  bus::Endpoint{host, port});
  }
  bool wait_for(const std::function<bool()>& happened) { return run_until(context_, happened); }
  /// The far end of a line that has been opened.
  tcp::socket* connect(FarEnd& far) {
    const int before = opened_;
    line_->open();
    return wait_for([&] { return opened_ > before; }) ? &far.accept() : nullptr;
  }
  static std::string name_of(std::uint16_t port) {
    return "tcp://127.0.0.1:" + std::to_string(port);
  }

  boost::asio::io_context context_;
  BlockingCalls blocking_{context_};
  std::optional<TcpLine> line_;
  int opened_ = 0;
  std::vector<std::string> warnings_;
  std::vector<std::string> lost_;
  std::string received_;
};

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
  ASSERT_TRUE(wait_for([&] { return !lost_.empty(); }));
  EXPECT_EQ(received_, kFrameText);
  EXPECT_EQ(lost_, std::vector<std::string>{name_of(far.port()) +
                                            ": the far end has closed the connection"});
  EXPECT_EQ(line_->transmit(kFrame), name_of(far.port()) + ": the connection is not open");
}

TEST_F(TcpLineTest, NoticesAReset) {
  FarEnd far(context_);
  make_line("127.0.0.1", far.port());
  tcp::socket* const peer = connect(far);
  ASSERT_NE(peer, nullptr);
  peer->set_option(tcp::socket::linger(true, 0));
  peer->close();
  ASSERT_TRUE(wait_for([&] { return !lost_.empty(); }));
  EXPECT_EQ(lost_, std::vector<std::string>{name_of(far.port()) + ": Connection reset by peer"});
}

TEST_F(TcpLineTest, SaysThatItCannotSendOnAConnectionThatHasGone) {
  FarEnd far(context_);
  make_line("127.0.0.1", far.port());
  tcp::socket* const peer = connect(far);
  ASSERT_NE(peer, nullptr);
  peer->set_option(tcp::socket::linger(true, 0));
  peer->close();
  EXPECT_EQ(line_->transmit(kFrame),
            name_of(far.port()) + ": cannot send: Connection reset by peer");
  context_.poll();
  EXPECT_TRUE(lost_.empty());
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
  ASSERT_TRUE(wait_for([&] { return lost_.size() == 1; }));
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
    ::connect(filling.back().native_handle(), address.data(),
              static_cast<socklen_t>(address.size()));
  }
  make_line("127.0.0.1", far.port());
  line_->open();
  ASSERT_TRUE(wait_for([&] { return !lost_.empty(); }));
  EXPECT_EQ(lost_, std::vector<std::string>{"cannot connect to " + name_of(far.port()) +
                                            ": Connection timed out"});
}

TEST_F(TcpLineTest, LooksUpANameAndTriesItsAddresses) {
  FarEnd far(context_);
  make_line("localhost", far.port());
  tcp::socket* const peer = connect(far);
  ASSERT_NE(peer, nullptr);
  ASSERT_EQ(line_->transmit(kFrame), std::nullopt);
  EXPECT_TRUE(wait_for([&] { return receive(*peer) == kFrameText; }));
}

TEST_F(TcpLineTest, NamesEachAddressOfANameThatWasTried) {
  FarEnd far(context_);
  far.stop_listening();
  const bus::Endpoint remote{"localhost", far.port()};
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
  make_line("localhost", far.port());
  line_->open();
  line_->close();
  ASSERT_NE(connect(far), nullptr);
  context_.poll();
  EXPECT_EQ(opened_, 1);
  EXPECT_TRUE(lost_.empty());
  EXPECT_FALSE(far.has_waiting());
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
            name_of(far.port()) + ": the far end has not taken the frame before");
  context_.poll();
  EXPECT_TRUE(lost_.empty());
  EXPECT_TRUE(was_reset(*peer));
}

TEST_F(TcpLineTest, DoesNotTransmitWhileClosed) {
  make_line("127.0.0.1", 502);
  EXPECT_EQ(line_->transmit(kFrame), "tcp://127.0.0.1:502: the connection is not open");
}

TEST(HostAddresses, AreNamedAsInAUrl) {
  EXPECT_EQ(to_text(bus::Endpoint{"drive.plant", 502}), "tcp://drive.plant:502");
  EXPECT_EQ(to_text(bus::Endpoint{"::1", 4001}), "tcp://[::1]:4001");
}

}  // namespace
}  // namespace mbgate::io
