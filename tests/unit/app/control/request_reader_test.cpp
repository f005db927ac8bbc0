// SPDX-License-Identifier: Apache-2.0
#include "app/control/request_reader.hpp"

#include <gtest/gtest.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/local/connect_pair.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <optional>
#include <string>
#include <utility>

#include "io/supervise.hpp"
#include "unit/io/run_until.hpp"

namespace mbgate::app {
namespace {

namespace http = boost::beast::http;
using boost::asio::local::stream_protocol;
using Incoming = std::optional<RequestReader::Incoming>;

/// A client that has sent something, and what was read of it.
class RequestReaderTest : public testing::Test {
 protected:
  void SetUp() override {
    stream_protocol::socket near(home_);
    boost::asio::local::connect_pair(near, far_);
    far_.non_blocking(true);
    stream_.emplace(std::move(near));
    reader_.emplace(*stream_);
  }
  /// What becomes of the next request, of which `text` comes, and then `more` until it is read.
  Incoming read(const std::string& text, const std::string& more = "") {
    bool is_done = false;
    Incoming incoming;
    io::supervise(home_, read_one(incoming, is_done), "reader");
    send(text);
    EXPECT_TRUE(io::run_until(home_, [&] {
      send(more);
      return is_done;
    }));
    return incoming;
  }

  [[nodiscard]] std::size_t sent() const { return sent_; }

 private:
  boost::asio::awaitable<void> read_one(Incoming& incoming, bool& is_done) {
    incoming = co_await reader_->read();
    is_done = true;
  }
  void send(const std::string& text) {
    boost::system::error_code full;
    sent_ += far_.write_some(boost::asio::buffer(text), full);
  }

  boost::asio::io_context home_;
  stream_protocol::socket far_{home_};
  std::optional<ControlStream> stream_;
  std::optional<RequestReader> reader_;
  std::size_t sent_ = 0;
};

TEST_F(RequestReaderTest, ReadsOneRequestAfterTheOther) {
  const Incoming first =
      read("POST /a HTTP/1.1\r\nContent-Length: 2\r\n\r\n{}GET /b HTTP/1.1\r\n\r\n");
  ASSERT_TRUE(first);
  EXPECT_EQ(first->request.target(), "/a");
  EXPECT_FALSE(first->refusal);
  const Incoming second = read("");
  ASSERT_TRUE(second);
  EXPECT_EQ(second->request.target(), "/b");
}

TEST_F(RequestReaderTest, RefusesABodyOfUnknownLengthByItsHead) {
  const Incoming incoming = read("GET /a HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n");
  ASSERT_TRUE(incoming && incoming->refusal);
  EXPECT_EQ(incoming->refusal->status, http::status::length_required);
}

TEST_F(RequestReaderTest, ReadsAShortBody) {
  const Incoming incoming =
      read("POST /a HTTP/1.1\r\nContent-Length: 4096\r\n\r\n" + std::string(4096, 'x'));
  ASSERT_TRUE(incoming);
  EXPECT_FALSE(incoming->refusal);
}

TEST_F(RequestReaderTest, RefusesALongOneByItsHead) {
  const Incoming incoming = read("POST /a HTTP/1.1\r\nContent-Length: 4097\r\n\r\n");
  ASSERT_TRUE(incoming && incoming->refusal);
  EXPECT_EQ(incoming->refusal->status, http::status::payload_too_large);
}

TEST_F(RequestReaderTest, RefusesWhatIsNoHttp) {
  const Incoming incoming = read("hello\r\n\r\n");
  ASSERT_TRUE(incoming && incoming->refusal);
  EXPECT_EQ(incoming->refusal->status, http::status::bad_request);
}

TEST_F(RequestReaderTest, EndsWhatHasNoEnd) {
  const Incoming incoming = read("GET / HTTP/1.1\r\nA: ", std::string(1024, 'x'));
  ASSERT_TRUE(incoming && incoming->refusal);
  EXPECT_EQ(incoming->refusal->status, http::status::request_header_fields_too_large);
  EXPECT_LT(sent(), std::size_t{1} << 20);
}

}  // namespace
}  // namespace mbgate::app
