// SPDX-License-Identifier: Apache-2.0
// Listeners whose sockets systemd keeps.
#include <gtest/gtest.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <utility>

#include "app/listeners.hpp"
#include "app/stored_sockets.hpp"

namespace mbgate::app {
namespace {

using boost::asio::ip::tcp;

/// Sockets that systemd keeps, of which it has copies, too.
class ListenersStored : public testing::Test {
 protected:
  ListenersStored() {
    lan_.name = "lan";
    lan_.address = "127.0.0.1";
    lan_.port = 0;
    lan_.port = io::bind_listener(context_, lan_)->local_endpoint().port();
  }
  StoredSockets stored() {
    return StoredSockets(
        [this](const std::string& name, int socket) {
          copies_.push_back({name, sys::UniqueFd(::dup(socket))});
          return true;
        },
        [this](const std::string& name) { removed_.push_back(name); });
  }
  std::string name() const { return "stored/lan/127.0.0.1%3A" + std::to_string(lan_.port); }
  bool begin(Listeners& listeners, StoredSockets& stored) {
    listeners.use(stored);
    return listeners.begin({lan_}, {});
  }

  Listeners::Take take() {
    return [this](gateway::ListenerId, tcp::acceptor acceptor) {
      taken_.push_back(std::move(acceptor));
    };
  }

  boost::asio::io_context context_;
  Log log_{false};
  std::vector<tcp::acceptor> taken_;
  gateway::ListenerSettings lan_;
  std::vector<InheritedSocket> copies_;
  std::vector<std::string> removed_;
};

TEST_F(ListenersStored, GoOnWithTheSocketOfTheEarlierProcess) {
  StoredSockets before = stored();
  Listeners first(context_, log_, take());
  ASSERT_TRUE(begin(first, before));
  ASSERT_EQ(copies_.size(), 1U);
  EXPECT_EQ(copies_[0].name, name());
  tcp::socket waiting(context_);
  waiting.connect(taken_[0].local_endpoint());
  taken_.clear();
  before.let_go();

  std::vector<InheritedSocket> handed_over = std::exchange(copies_, {});
  StoredSockets after = stored();
  after.take(handed_over, {lan_});
  Listeners next(context_, log_, take());
  ASSERT_TRUE(begin(next, after));
  ASSERT_EQ(taken_.size(), 1U);
  EXPECT_EQ(taken_[0].accept().remote_endpoint(), waiting.local_endpoint());
  ASSERT_EQ(copies_.size(), 1U);  // which systemd has already
  EXPECT_EQ(copies_[0].name, name());
  EXPECT_TRUE(removed_.empty());
}

TEST_F(ListenersStored, LeaveAnAddressOfWhichSystemdHasACopy) {
  StoredSockets kept = stored();
  Listeners listeners(context_, log_, take());
  ASSERT_TRUE(begin(listeners, kept));
  listeners.start();
  auto changed = lan_;
  changed.tcp.keepalive_probes = 9;
  const auto drop = [this](gateway::ListenerId) { taken_.clear(); };
  EXPECT_TRUE(listeners.reload({lan_}, {changed}, drop));
  EXPECT_EQ(removed_, std::vector{name()});
  ASSERT_EQ(copies_.size(), 2U);  // the first one listens no more, and the second one does
  EXPECT_EQ(copies_[1].name, name());
  tcp::socket client(context_);
  client.connect(taken_.at(0).local_endpoint());
  EXPECT_EQ(taken_[0].accept().remote_endpoint(), client.local_endpoint());
}

}  // namespace
}  // namespace mbgate::app
