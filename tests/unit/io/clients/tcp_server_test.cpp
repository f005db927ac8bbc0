// SPDX-License-Identifier: Apache-2.0
#include "io/clients/tcp_server.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <chrono>
#include <limits>
#include <memory>
#include <thread>
#include <vector>

#include "io/clock.hpp"
#include "socket_pair.hpp"
#include "unit/io/run_until.hpp"

namespace mbgate::io {
namespace {

using boost::asio::ip::tcp;

class TcpServerTest : public testing::Test, public AcceptEvents {
 protected:
  void client_accepted(gateway::ListenerId /*listener*/, AcceptedClient client) override {
    accepted_.push_back(std::move(client));
  }
  void accept_failed(gateway::ListenerId /*listener*/,
                     const boost::system::error_code& error) override {
    failures_.push_back(error.value());
  }
  /// UndefinedBehaviorSanitizer needs a descriptor when it sees a kind of object for the first
  /// time. Here that is the error of a server without descriptors.
  void fail_once() {
    tcp::acceptor acceptor = *bind_listener(context_, loopback_listener());
    const TestClient client(context_, acceptor.local_endpoint());
    TcpServer server(context_, gateway::ListenerId{4}, std::move(acceptor), *this, 0);
    server.start();
    ASSERT_TRUE(run_until(context_, [&] { return !failures_.empty(); }));
    server.stop();
    context_.poll();
    failures_.clear();
  }
  std::unique_ptr<TestClient> connect() { return std::make_unique<TestClient>(context_, address_); }

  boost::asio::io_context context_;
  tcp::acceptor acceptor_ = *bind_listener(context_, loopback_listener());
  tcp::endpoint address_ = acceptor_.local_endpoint();
  TcpServer server_{context_, gateway::ListenerId{3}, std::move(acceptor_), *this,
                    std::numeric_limits<int>::max()};
  std::vector<AcceptedClient> accepted_;
  std::vector<int> failures_;
};

TEST_F(TcpServerTest, DoesNotKnowSinceWhenThoseWaitThatCameBeforeTheStart) {
  const auto client = connect();
  server_.accept_waiting();
  ASSERT_EQ(accepted_.size(), 1U);
  EXPECT_EQ(accepted_[0].connected, bus::Instant::min());
  EXPECT_EQ(accepted_[0].peer, client->socket().local_endpoint());
}

// The time that passes here is what it is about: nobody accepts meanwhile.
TEST_F(TcpServerTest, KnowsSinceWhenAConnectionHasWaited) {
  constexpr std::chrono::milliseconds kCoarse{20};  // the kernel counts in ticks
  server_.start();
  const bus::Instant before = now();
  const auto client = connect();
  const bus::Instant after = now();
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  ASSERT_TRUE(run_until(context_, [&] { return !accepted_.empty(); }));
  EXPECT_GE(accepted_[0].connected, before - kCoarse);
  EXPECT_LE(accepted_[0].connected, after + kCoarse);
}

TEST_F(TcpServerTest, AcceptsMoreClientsThanOneBatch) {
  server_.start();
  std::vector<std::unique_ptr<TestClient>> clients;
  clients.reserve(100);
  for (int i = 0; i < 100; ++i) {
    clients.push_back(connect());
  }
  EXPECT_TRUE(run_until(context_, [&] { return accepted_.size() == clients.size(); }));
}

TEST_F(TcpServerTest, AcceptsNoMoreOnceStopped) {
  server_.start();
  server_.stop();
  EXPECT_THROW(connect(), boost::system::system_error);
}

TEST_F(TcpServerTest, SurvivesRunningOutOfDescriptors) {
  fail_once();
  server_.start();
  const auto before_that = connect();
  ASSERT_TRUE(run_until(context_, [&] { return accepted_.size() == 1; }));
  const auto refused = connect();
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  const sys::UniqueFd first_free(::dup(0));
  rlimit none_left = before;
  none_left.rlim_cur = static_cast<rlim_t>(first_free.get());
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &none_left), 0);
  const bool failed = run_until(context_, [&] { return !failures_.empty(); });
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
  ASSERT_TRUE(failed);
  EXPECT_EQ(failures_[0], EMFILE);
  EXPECT_EQ(accepted_.size(), 1U);
  // The client that could not be had knows.
  bool ended = false;
  EXPECT_TRUE(run_until(context_, [&] {
    refused->receive(&ended);
    return ended;
  }));
  // The next one is served.
  const auto served = connect();
  EXPECT_TRUE(run_until(context_, [&] { return accepted_.size() == 2; }));
}

TEST_F(TcpServerTest, LeavesDescriptorsToOthers) {
  tcp::acceptor acceptor = *bind_listener(context_, loopback_listener());
  const auto address = acceptor.local_endpoint();
  std::vector<std::unique_ptr<TestClient>> clients;
  clients.reserve(5);
  for (int i = 0; i < 5; ++i) {
    clients.push_back(std::make_unique<TestClient>(context_, address));
  }
  const sys::UniqueFd probe(::dup(0));
  // The server's spare one takes the lowest, two clients the next ones.
  TcpServer server(context_, gateway::ListenerId{3}, std::move(acceptor), *this, probe.get() + 4);
  server.start();
  ASSERT_TRUE(run_until(context_, [&] { return !failures_.empty(); }));
  EXPECT_EQ(failures_[0], EMFILE);
  EXPECT_EQ(accepted_.size(), 2U);
  for (auto& client : accepted_) {
    EXPECT_LT(client.socket.native_handle(), probe.get() + 4);
  }
  // The other three know.
  std::size_t ended = 0;
  EXPECT_TRUE(run_until(context_, [&] {
    ended = 0;
    for (const auto& client : clients) {
      bool gone = false;
      client->receive(&gone);
      ended += gone ? 1 : 0;
    }
    return ended == 3;
  }));
  // Once descriptors are free again the next one is served.
  clients.clear();
  const TestClient served(context_, address);
  EXPECT_TRUE(run_until(context_, [&] { return accepted_.size() == 3; }));
  server.stop();
}

}  // namespace
}  // namespace mbgate::io
