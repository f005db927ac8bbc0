// SPDX-License-Identifier: Apache-2.0
#include "app/control/control_doors.hpp"

#include <gtest/gtest.h>

#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/error.hpp>
#include <string>
#include <utility>
#include <vector>

#include "routing/client_address.hpp"
#include "unit/io/run_until.hpp"

namespace mbgate::app {
namespace {

using boost::asio::ip::tcp;
using routing::ListenerId;

constexpr ListenerId kDoor{0};
constexpr ListenerId kOtherDoor{1};

/// Two TCP addresses, and who has entered.
class ControlDoorsTest : public testing::Test {
 protected:
  void SetUp() override {
    doors_.allow(routing::loopback_networks());
    for (const ListenerId id : {kDoor, kOtherDoor}) {
      auto acceptor = std::make_shared<tcp::acceptor>(*home_, tcp::endpoint(tcp::v4(), 0));
      ports_.push_back(acceptor->local_endpoint().port());
      doors_.open(id, std::move(acceptor));
    }
  }
  tcp::socket connect(ListenerId door) {
    tcp::socket client(*home_);
    client.connect(
        {boost::asio::ip::address_v4::loopback(), ports_.at(static_cast<std::size_t>(door))});
    client.non_blocking(true);
    return client;
  }
  /// A client, and its connection on this side.
  std::pair<tcp::socket, std::shared_ptr<ControlStream>> enter(ListenerId door) {
    const std::size_t before = entered_.size();
    tcp::socket client = connect(door);
    EXPECT_TRUE(io::run_until(*home_, [&] { return entered_.size() > before; }));
    return {std::move(client), entered_.back().stream};
  }
  /// What it gets until its connection ends.
  std::string told(tcp::socket& client) {
    std::string text;
    EXPECT_TRUE(io::run_until(*home_, [&] {
      std::array<char, 1024> bytes{};
      boost::system::error_code error;
      text.append(bytes.data(), client.read_some(boost::asio::buffer(bytes), error));
      return error == boost::asio::error::eof;
    }));
    return text;
  }

  std::shared_ptr<boost::asio::io_context> home_ = std::make_shared<boost::asio::io_context>(1);
  std::vector<std::uint16_t> ports_;
  std::vector<ControlDoors::Entered> entered_;
  std::vector<std::string> refused_;
  ControlDoors doors_{
      home_, [this](ControlDoors::Entered client) { entered_.push_back(std::move(client)); },
      [this](const std::string& address) { refused_.push_back(address); }};
};

TEST_F(ControlDoorsTest, CloseWhoMayNotReadAnyMore) {
  auto [client, stream] = enter(kDoor);
  doors_.allow({*routing::Network::parse("127.0.0.0/8"), *routing::Network::parse("10.0.0.0/8")});
  EXPECT_TRUE(stream->socket().is_open());
  doors_.allow({*routing::Network::parse("10.0.0.0/8")});
  EXPECT_FALSE(stream->socket().is_open());
  EXPECT_EQ(told(client), "");
  EXPECT_EQ(refused_, std::vector<std::string>{});
  tcp::socket later = connect(kDoor);
  EXPECT_EQ(told(later).substr(0, 12), "HTTP/1.1 403");
  EXPECT_EQ(refused_, std::vector<std::string>{"127.0.0.1"});
}

TEST_F(ControlDoorsTest, SeeOutThoseOfOneAddress) {
  auto [client, stream] = enter(kDoor);
  auto [other_client, other_stream] = enter(kOtherDoor);
  doors_.close(kDoor);
  EXPECT_TRUE(stream->socket().is_open());
  doors_.close_clients(kDoor);
  EXPECT_FALSE(stream->socket().is_open());
  EXPECT_TRUE(other_stream->socket().is_open());
  EXPECT_EQ(told(client), "");
}

TEST_F(ControlDoorsTest, KeepDescriptorsForOthers) {
  doors_.set_end(0);
  tcp::socket client = connect(kDoor);
  EXPECT_EQ(told(client), "");
  EXPECT_TRUE(entered_.empty());
}

}  // namespace
}  // namespace mbgate::app
