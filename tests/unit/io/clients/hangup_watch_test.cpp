// SPDX-License-Identifier: Apache-2.0
#include "io/clients/hangup_watch.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "unit/io/clients/socket_pair.hpp"
#include "unit/io/run_until.hpp"

namespace mbgate::io {
namespace {

using boost::asio::ip::tcp;

class HangupWatchTest : public testing::Test {
 protected:
  struct Report {
    std::uint64_t key;
    Hangup hangup;
    friend bool operator==(const Report&, const Report&) = default;
  };

  bool run_until_reports(std::size_t count) {
    return run_until(context_, [&] { return reports_.size() >= count; });
  }

  boost::asio::io_context context_;
  tcp::acceptor acceptor_ = *bind_listener(context_, loopback_listener());
  std::vector<Report> reports_;
  HangupWatch watch_{context_, [this](std::uint64_t key, Hangup hangup) {
                       reports_.push_back({key, hangup});
                     }};
  TestClient client_{context_, acceptor_};
  tcp::socket server_ = acceptor_.accept();
};

TEST_F(HangupWatchTest, NoticesAFinBehindUnreadData) {
  ASSERT_TRUE(watch_.watch(server_.native_handle(), 7, true));
  ASSERT_TRUE(client_.send("unread"));
  client_.send_fin();
  ASSERT_TRUE(run_until_reports(1));
  EXPECT_EQ(reports_, (std::vector<Report>{{7, Hangup::fin}}));
}

TEST_F(HangupWatchTest, NoticesAResetBehindUnreadData) {
  ASSERT_TRUE(watch_.watch(server_.native_handle(), 8, true));
  ASSERT_TRUE(client_.send("unread"));
  client_.reset();
  ASSERT_TRUE(run_until_reports(1));
  EXPECT_EQ(reports_, (std::vector<Report>{{8, Hangup::reset}}));
}

TEST_F(HangupWatchTest, NoticesAResetAfterAFin) {
  ASSERT_TRUE(watch_.watch(server_.native_handle(), 9, true));
  client_.send_fin();
  ASSERT_TRUE(run_until_reports(1));
  ASSERT_TRUE(watch_.watch(server_.native_handle(), 9, false));
  client_.reset();
  ASSERT_TRUE(run_until_reports(2));
  EXPECT_EQ(reports_, (std::vector<Report>{{9, Hangup::fin}, {9, Hangup::reset}}));
}

TEST_F(HangupWatchTest, DoesNotReportAForgottenSocket) {
  ASSERT_TRUE(watch_.watch(server_.native_handle(), 1, true));
  watch_.forget(server_.native_handle());
  TestClient other(context_, acceptor_);
  tcp::socket other_server = acceptor_.accept();
  ASSERT_TRUE(watch_.watch(other_server.native_handle(), 2, true));
  client_.send_fin();
  other.send_fin();
  ASSERT_TRUE(run_until_reports(1));
  EXPECT_EQ(reports_, (std::vector<Report>{{2, Hangup::fin}}));
}

}  // namespace
}  // namespace mbgate::io
