// SPDX-License-Identifier: Apache-2.0
#include "io/clients/tcp_connection.hpp"

#include <gtest/gtest.h>

#include <string>

#include "socket_pair.hpp"
#include "unit/io/run_until.hpp"

namespace mbgate::io {
namespace {

using boost::asio::ip::tcp;

constexpr auto kLimit = std::chrono::seconds(60);
constexpr gateway::ClientId kClient{42};

class TcpConnectionTest : public testing::Test, public ConnectionEvents {
 protected:
  void client_bytes(gateway::ClientId /*client*/, modbus::Bytes bytes,
                    std::size_t /*unread*/) override {
    received_.append(bytes.begin(), bytes.end());
  }
  void client_sent(gateway::ClientId /*client*/) override { ++sent_; }
  void client_half_closed(gateway::ClientId /*client*/) override { ++half_closed_; }
  void client_disconnected(gateway::ClientId /*client*/, modbus::Bytes bytes) override {
    disconnected_ = true;
    read_when_gone_.assign(bytes.begin(), bytes.end());
  }
  void client_closed(gateway::ClientId /*client*/) override { closed_ = true; }

  bool wait_for(const std::function<bool()>& happened) { return run_until(context_, happened); }

  static modbus::MbapBytes adu_of(std::uint8_t byte) {
    return modbus::MbapBytes(modbus::kMaxMbapAduSize, byte);
  }
  /// Sends until the client takes no more; the number of ADUs sent or queued.
  std::size_t send_until_queued() {
    std::size_t count = 1;
    while (connection_->send(adu_of(static_cast<std::uint8_t>(count))) ==
           TcpConnection::SendOutcome::sent) {
      ++count;
    }
    return count;
  }

  boost::asio::io_context context_;
  tcp::acceptor acceptor_ = *bind_listener(context_, loopback_listener());
  TestClient client_{context_, acceptor_};
  HangupWatch hangups_{context_, [this](std::uint64_t key, Hangup hangup) {
                         ASSERT_EQ(key, 42U);
                         connection_->handle_hangup(hangup);
                       }};
  ConnectionContext connection_context_{context_, hangups_, *this, {}};
  std::shared_ptr<TcpConnection> connection_ =
      std::make_shared<TcpConnection>(connection_context_, kClient, acceptor_.accept());
  std::string received_;
  std::string read_when_gone_;
  int sent_ = 0;
  int half_closed_ = 0;
  bool disconnected_ = false;
  bool closed_ = false;
};

TEST_F(TcpConnectionTest, HandsOverBytesThenTheFin) {
  connection_->start();
  ASSERT_TRUE(client_.send("request"));
  client_.send_fin();
  ASSERT_TRUE(wait_for([&] { return half_closed_ == 1; }));
  EXPECT_EQ(received_, "request");
  EXPECT_FALSE(disconnected_);
}

// The kernel gives bytes though a reset has come behind them.
TEST_F(TcpConnectionTest, HandsOverNoRequestOfAClientThatHasGone) {
  ASSERT_TRUE(client_.send("request"));
  client_.reset();
  connection_->start();
  ASSERT_TRUE(wait_for([&] { return disconnected_; }));
  EXPECT_EQ(received_, "");
  EXPECT_EQ(read_when_gone_, "request");
}

// It may have been a stop.
TEST_F(TcpConnectionTest, HandsOverWhatWasUnreadWhenSendingFails) {
  send_until_queued();
  ASSERT_TRUE(client_.send("request"));
  client_.reset();
  ASSERT_TRUE(wait_for([&] { return disconnected_; }));
  EXPECT_EQ(read_when_gone_, "request");
}

TEST_F(TcpConnectionTest, HandsOverAllThatAClientHasSentThatHasGone) {
  const std::string requests(3 * gateway::kClientReadSize, 'r');
  ASSERT_TRUE(client_.send(requests));
  client_.reset();
  connection_->start();
  ASSERT_TRUE(wait_for([&] { return disconnected_; }));
  EXPECT_EQ(read_when_gone_, requests);
}

TEST_F(TcpConnectionTest, GivesBackWhatWasUnreadWhenItIsAborted) {
  const std::string requests(3 * gateway::kClientReadSize, 'r');
  ASSERT_TRUE(client_.send(requests));
  client_.reset();
  ASSERT_EQ(connection_->send(adu_of(1)), TcpConnection::SendOutcome::failed);
  const modbus::Bytes unread = connection_->abort();
  EXPECT_EQ(std::string(unread.begin(), unread.end()), requests);
}

TEST_F(TcpConnectionTest, StillSendsAfterTheFin) {
  connection_->start();
  client_.send_fin();
  ASSERT_TRUE(wait_for([&] { return half_closed_ == 1; }));
  EXPECT_EQ(connection_->send(adu_of(1)), TcpConnection::SendOutcome::sent);
  std::string answer;
  EXPECT_TRUE(wait_for([&] {
    answer += client_.receive();
    return answer.size() == modbus::kMaxMbapAduSize;
  }));
}

TEST_F(TcpConnectionTest, NoticesAResetAfterTheFin) {
  connection_->start();
  client_.send_fin();
  ASSERT_TRUE(wait_for([&] { return half_closed_ == 1; }));
  client_.reset();
  EXPECT_TRUE(wait_for([&] { return disconnected_; }));
}

TEST_F(TcpConnectionTest, NoticesAReset) {
  connection_->start();
  client_.reset();
  EXPECT_TRUE(wait_for([&] { return disconnected_; }));
}

TEST_F(TcpConnectionTest, PausedNoticesTheFinButReadsNothing) {
  connection_->start();
  ASSERT_TRUE(connection_->pause());
  ASSERT_TRUE(client_.send("later"));
  client_.send_fin();
  ASSERT_TRUE(wait_for([&] { return half_closed_ == 1; }));
  EXPECT_EQ(received_, "");
  connection_->resume();
  ASSERT_TRUE(wait_for([&] { return half_closed_ == 2; }));
  EXPECT_EQ(received_, "later");
}

TEST_F(TcpConnectionTest, PausedNoticesAReset) {
  connection_->start();
  ASSERT_TRUE(connection_->pause());
  ASSERT_TRUE(client_.send("never read"));
  client_.reset();
  ASSERT_TRUE(wait_for([&] { return disconnected_; }));
  EXPECT_EQ(received_, "");
}

TEST_F(TcpConnectionTest, PausedAgainAfterTheFinNoticesAReset) {
  connection_->start();
  ASSERT_TRUE(connection_->pause());
  ASSERT_TRUE(client_.send("unread"));
  client_.send_fin();
  ASSERT_TRUE(wait_for([&] { return half_closed_ == 1; }));
  connection_->resume();
  ASSERT_TRUE(connection_->pause());
  client_.reset();
  EXPECT_TRUE(wait_for([&] { return disconnected_; }));
}

TEST_F(TcpConnectionTest, ResumesWhatWasPaused) {
  connection_->start();
  for (int i = 1; i <= 3; ++i) {
    ASSERT_TRUE(connection_->pause());
    ASSERT_TRUE(client_.send("x"));
    context_.restart();
    context_.poll();
    connection_->resume();
    ASSERT_TRUE(wait_for([&] { return received_.size() == static_cast<std::size_t>(i); }));
  }
}

TEST_F(TcpConnectionTest, QueuesForASlowReaderAndConfirmsInOrder) {
  const std::size_t count = send_until_queued();
  EXPECT_EQ(connection_->send(adu_of(0)), TcpConnection::SendOutcome::queued);
  EXPECT_EQ(sent_, 0);
  std::string answers;
  ASSERT_TRUE(wait_for([&] {
    answers += client_.receive();
    return answers.size() == (count + 1) * modbus::kMaxMbapAduSize;
  }));
  EXPECT_EQ(sent_, 2);
  for (std::size_t i = 0; i <= count; ++i) {
    const auto expected = static_cast<char>(i == count ? 0 : static_cast<std::uint8_t>(i + 1));
    ASSERT_EQ(answers.substr(i * modbus::kMaxMbapAduSize, modbus::kMaxMbapAduSize),
              std::string(modbus::kMaxMbapAduSize, expected))
        << "answer " << i;
  }
}

TEST_F(TcpConnectionTest, ReportsAClientThatGoesWithAnswersQueued) {
  send_until_queued();
  client_.reset();
  EXPECT_TRUE(wait_for([&] { return disconnected_; }));
}

TEST_F(TcpConnectionTest, ClosesAtOnceWhenNothingWasSent) {
  connection_->start();
  connection_->close(kLimit);
  EXPECT_TRUE(closed_);
  bool ended = false;
  EXPECT_TRUE(wait_for([&] {
    client_.receive(&ended);
    return ended;
  }));
}

TEST_F(TcpConnectionTest, SendsWhatIsQueuedBeforeItCloses) {
  connection_->start();
  const std::size_t count = send_until_queued();
  ASSERT_TRUE(client_.send("a request that nobody reads any more"));
  connection_->close(kLimit);
  EXPECT_FALSE(closed_);
  std::string answers;
  bool ended = false;
  ASSERT_TRUE(wait_for([&] {
    answers += client_.receive(&ended);
    return ended;
  }));
  EXPECT_EQ(answers.size(), count * modbus::kMaxMbapAduSize);
  client_.socket().close();
  EXPECT_TRUE(wait_for([&] { return closed_; }));
  EXPECT_EQ(sent_, 0);
  EXPECT_FALSE(disconnected_);
}

TEST_F(TcpConnectionTest, ClosesInTheEndEvenIfTheClientNeverReads) {
  send_until_queued();
  connection_->close(std::chrono::milliseconds(10));
  EXPECT_TRUE(wait_for([&] { return closed_; }));
}

}  // namespace
}  // namespace mbgate::io
