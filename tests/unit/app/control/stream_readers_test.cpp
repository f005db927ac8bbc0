// SPDX-License-Identifier: Apache-2.0
#include "app/control/stream_readers.hpp"

#include <gtest/gtest.h>

#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/local/connect_pair.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/write.hpp>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "io/supervise.hpp"
#include "unit/io/run_until.hpp"

namespace mbgate::app {
namespace {

using boost::asio::local::stream_protocol;

/// A reader and the other end of its connection.
class StreamReadersTest : public testing::Test {
 protected:
  void SetUp() override {
    stream_protocol::socket near(home_);
    boost::asio::local::connect_pair(near, far_);
    stream_ = std::make_unique<ControlStream>(std::move(near));
    io::supervise(home_, follow(), "reader");
    ASSERT_TRUE(io::run_until(home_, [this] { return asked_ > 0; }));
  }

  boost::asio::awaitable<void> follow() {
    std::function<std::string()> next = [this] {
      ++asked_;
      return std::exchange(news_, {});
    };
    co_await readers_.feed(*stream_, std::move(next));
    has_ended_ = true;
  }
  /// Whatever can happen without waiting.
  void settle() {
    constexpr int kMany = 20;
    for (int i = 0; i < kMany; ++i) {
      home_.restart();
      home_.poll();
    }
  }
  std::string received() {
    std::array<char, 4096> bytes{};
    const std::size_t size = far_.read_some(boost::asio::buffer(bytes));
    return {bytes.data(), size};
  }

  boost::asio::io_context home_;
  stream_protocol::socket far_{home_};
  std::unique_ptr<ControlStream> stream_;
  StreamReaders readers_;
  std::string news_;
  int asked_ = 0;
  bool has_ended_ = false;
};

TEST_F(StreamReadersTest, AreSentNothingWhileWhatIsNewIsNotForThem) {
  for (int i = 0; i < 20; ++i) {
    const int before = asked_;
    readers_.wake();
    ASSERT_TRUE(io::run_until(home_, [&] { return asked_ > before; }));
  }
  settle();
  news_ = "data: 1\n\n";
  readers_.wake();
  ASSERT_TRUE(io::run_until(home_, [&] { return news_.empty(); }));
  settle();
  const std::string text = received();
  EXPECT_EQ(text.substr(text.find("\r\n\r\n")), "\r\n\r\ndata: 1\n\n");
}

TEST_F(StreamReadersTest, EndWithTheirConnectionWhoeverClosesIt) {
  settle();
  EXPECT_FALSE(has_ended_);
  stream_->close();
  settle();
  EXPECT_TRUE(has_ended_);
}

TEST_F(StreamReadersTest, EndWithAClientThatHasSentMore) {
  boost::asio::write(far_, boost::asio::buffer("more"));
  settle();
  EXPECT_FALSE(has_ended_);
  far_.close();
  settle();
  EXPECT_TRUE(has_ended_);  // at once, not with the next comment
}

TEST_F(StreamReadersTest, EndWithTheirClient) {
  far_.close();
  EXPECT_TRUE(io::run_until(home_, [this] { return has_ended_; }));
}

}  // namespace
}  // namespace mbgate::app
