// SPDX-License-Identifier: Apache-2.0
#include "io/clients/listening_socket.hpp"

#include <gtest/gtest.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include "socket_pair.hpp"

namespace mbgate::io {
namespace {

using boost::asio::ip::tcp;

int option_of(int socket, int level, int name) {
  int value = -1;
  socklen_t size = sizeof value;
  ::getsockopt(socket, level, name, &value, &size);
  return value;
}

TEST(ListeningSocket, GivesItsOptionsToEveryConnection) {
  boost::asio::io_context context;
  auto listener = loopback_listener();
  listener.tcp.keepalive_idle = std::chrono::seconds(7);
  listener.tcp.keepalive_interval = std::chrono::seconds(3);
  listener.tcp.keepalive_probes = 2;
  listener.tcp.user_timeout = std::chrono::milliseconds(4500);
  auto acceptor = bind_listener(context, listener);
  ASSERT_TRUE(acceptor.has_value()) << acceptor.error().why;
  const TestClient client(context, *acceptor);
  tcp::socket accepted = acceptor->accept();
  const int socket = accepted.native_handle();
  EXPECT_EQ(option_of(socket, IPPROTO_TCP, TCP_NODELAY), 1);
  EXPECT_EQ(option_of(socket, SOL_SOCKET, SO_KEEPALIVE), 1);
  EXPECT_EQ(option_of(socket, IPPROTO_TCP, TCP_KEEPIDLE), 7);
  EXPECT_EQ(option_of(socket, IPPROTO_TCP, TCP_KEEPINTVL), 3);
  EXPECT_EQ(option_of(socket, IPPROTO_TCP, TCP_KEEPCNT), 2);
  EXPECT_EQ(option_of(socket, IPPROTO_TCP, TCP_USER_TIMEOUT), 4500);
}

TEST(ListeningSocket, LeavesKeepaliveOffWhenItsTimeIsZero) {
  boost::asio::io_context context;
  auto listener = loopback_listener();
  listener.tcp.keepalive_idle = bus::Duration::zero();
  auto acceptor = bind_listener(context, listener);
  ASSERT_TRUE(acceptor.has_value()) << acceptor.error().why;
  EXPECT_EQ(option_of(acceptor->native_handle(), SOL_SOCKET, SO_KEEPALIVE), 0);
}

TEST(ListeningSocket, OfAnEarlierProcessGetsTheOptionsOfNow) {
  boost::asio::io_context context;
  auto listener = loopback_listener();
  auto before = bind_listener(context, listener);
  ASSERT_TRUE(before.has_value()) << before.error().why;
  listener.port = before->local_endpoint().port();
  listener.tcp.keepalive_idle = bus::Duration::zero();
  listener.tcp.backlog = 1;
  TestClient waiting(context, *before);
  auto after = adopt_listener(context, listener, sys::UniqueFd(before->release()));
  ASSERT_TRUE(after.has_value()) << after.error().why;
  EXPECT_EQ(option_of(after->native_handle(), SOL_SOCKET, SO_KEEPALIVE), 0);
  tcp_info info{};
  socklen_t size = sizeof info;
  ASSERT_EQ(::getsockopt(after->native_handle(), IPPROTO_TCP, TCP_INFO, &info, &size), 0);
  EXPECT_EQ(info.tcpi_sacked, 1U);  // of a socket that listens: its backlog
  EXPECT_EQ(after->accept().remote_endpoint(), waiting.socket().local_endpoint());
}

TEST(ListeningSocket, IsBoundForAListenerOfItsAddressAlone) {
  boost::asio::io_context context;
  auto listener = loopback_listener();
  auto acceptor = bind_listener(context, listener);
  ASSERT_TRUE(acceptor.has_value()) << acceptor.error().why;
  const int socket = acceptor->native_handle();
  EXPECT_FALSE(is_bound_for(listener, socket));  // at port 0
  listener.port = acceptor->local_endpoint().port();
  EXPECT_TRUE(is_bound_for(listener, socket));
  for (const char* const other : {"127.0.0.2", "0.0.0.0", "::ffff:127.0.0.1", "plc.local"}) {
    listener.address = other;
    EXPECT_FALSE(is_bound_for(listener, socket)) << other;
  }
}

// A socket for IPv4 too is none of ours.
TEST(ListeningSocket, IsBoundForIpv6Alone) {
  boost::asio::io_context context;
  auto listener = loopback_listener();
  listener.address = "::";
  auto acceptor = bind_listener(context, listener);
  if (!acceptor) {
    GTEST_SKIP() << "skipped: no IPv6: " << acceptor.error().why;
  }
  listener.port = acceptor->local_endpoint().port();
  EXPECT_TRUE(is_bound_for(listener, acceptor->native_handle()));
  tcp::acceptor both(context, tcp::v6());
  both.bind({tcp::v6(), 0});
  both.listen();
  listener.port = both.local_endpoint().port();
  EXPECT_FALSE(is_bound_for(listener, both.native_handle()));
  both.close();
  EXPECT_FALSE(is_bound_for(listener, 0));
}

TEST(ListeningSocket, NamesListenerAndAddressWhenThePortIsTaken) {
  boost::asio::io_context context;
  const auto first = bind_listener(context, loopback_listener());
  ASSERT_TRUE(first.has_value()) << first.error().why;
  auto listener = loopback_listener();
  listener.port = first->local_endpoint().port();
  const auto second = bind_listener(context, listener);
  ASSERT_FALSE(second.has_value());
  EXPECT_EQ(second.error().why, "listener \"test\": cannot listen on 127.0.0.1:" +
                                    std::to_string(listener.port) + ": Address already in use");
  EXPECT_FALSE(second.error().absent);
}

TEST(ListeningSocket, NamesAnAddressThatIsNone) {
  boost::asio::io_context context;
  auto listener = loopback_listener();
  listener.address = "plc.local";
  const auto acceptor = bind_listener(context, listener);
  ASSERT_FALSE(acceptor.has_value());
  EXPECT_EQ(acceptor.error().why,
            "listener \"test\": cannot listen on plc.local: this is not an IPv4 or IPv6 address");
}

/// An address for documentation (RFC 5737), which no machine has.
constexpr const char* kNobodys = "192.0.2.77";

TEST(ListeningSocket, TellsAnAddressThatIsNotThereFromOtherFailures) {
  boost::asio::io_context context;
  auto listener = loopback_listener();
  listener.address = kNobodys;
  listener.port = 1502;
  const auto acceptor = bind_listener(context, listener);
  ASSERT_FALSE(acceptor.has_value());
  EXPECT_EQ(acceptor.error().why,
            "listener \"test\": cannot listen on 192.0.2.77:1502: Cannot assign requested address");
  EXPECT_TRUE(acceptor.error().absent);
}

TEST(ListeningSocket, ListensOnAnAddressThatIsNotThereIfAskedTo) {
  boost::asio::io_context context;
  auto listener = loopback_listener();
  listener.freebind = true;
  for (const auto* address : {kNobodys, "2001:db8::77"}) {
    listener.address = address;
    const auto acceptor = bind_listener(context, listener);
    ASSERT_TRUE(acceptor.has_value()) << acceptor.error().why;
    EXPECT_EQ(acceptor->local_endpoint().address().to_string(), address);
  }
}

TEST(ListeningSocket, OfIpv6LeavesThePortFreeForIpv4) {
  boost::asio::io_context context;
  auto listener = loopback_listener();
  std::string why;
  for (int tries = 0; tries < 10; ++tries) {  // somebody else may just use the port
    listener.address = "::";
    listener.port = 0;
    const auto v6 = bind_listener(context, listener);
    if (!v6) {
      GTEST_SKIP() << "skipped: no IPv6 here: " << v6.error().why;
    }
    listener.address = "0.0.0.0";
    listener.port = v6->local_endpoint().port();
    const auto v4 = bind_listener(context, listener);
    if (v4) {
      return;
    }
    why = v4.error().why;
  }
  FAIL() << why;
}

TEST(ListeningSocket, CanBeTakenOverFromSystemd) {
  boost::asio::io_context context;
  sys::UniqueFd inherited(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  ASSERT_EQ(::listen(inherited.get(), 8), 0);  // unbound: the kernel chooses a port
  auto acceptor = adopt_listener(context, loopback_listener(), std::move(inherited));
  ASSERT_TRUE(acceptor.has_value()) << acceptor.error().why;
  const tcp::endpoint here(boost::asio::ip::address_v4::loopback(),
                           acceptor->local_endpoint().port());
  const TestClient client(context, here);
  tcp::socket accepted = acceptor->accept();
  EXPECT_EQ(option_of(accepted.native_handle(), IPPROTO_TCP, TCP_NODELAY), 1);
}

TEST(ListeningSocket, RefusesAnInheritedSocketThatDoesNotListen) {
  boost::asio::io_context context;
  const auto acceptor = adopt_listener(
      context, loopback_listener(), sys::UniqueFd(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)));
  ASSERT_FALSE(acceptor.has_value());
  EXPECT_EQ(acceptor.error().why,
            "listener \"test\": cannot listen on the socket from systemd: it is not a listening "
            "TCP socket");
}

TEST(EndpointText, PutsIpv6InBrackets) {
  EXPECT_EQ(to_text(tcp::endpoint(boost::asio::ip::make_address("127.0.0.1"), 502)),
            "127.0.0.1:502");
  EXPECT_EQ(to_text(tcp::endpoint(boost::asio::ip::make_address("::1"), 1502)), "[::1]:1502");
}

}  // namespace
}  // namespace mbgate::io
