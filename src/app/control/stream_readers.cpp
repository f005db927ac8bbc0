// SPDX-License-Identifier: Apache-2.0
#include "app/control/stream_readers.hpp"

#include <poll.h>
#include <sys/socket.h>

#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/write.hpp>
#include <string_view>

#include "io/supervise.hpp"

namespace mbgate::app {
namespace {

/// So often at least something is sent: both ends see that the other is there.
constexpr std::chrono::seconds kCommentInterval{15};
constexpr std::string_view kComment = ":\n\n";

/// It has no length: it ends with the connection.
constexpr std::string_view kStreamHead =
    "HTTP/1.1 200 OK\r\n"
    "Content-Type: text/event-stream\r\n"
    "Cache-Control: no-store\r\n"
    "Connection: close\r\n"
    "\r\n";

/// Not where the other end of a Unix socket only sends no more. TCP does not tell that from its
/// end.
bool is_closed(int descriptor) {
  int family = AF_UNIX;
  socklen_t size = sizeof family;
  ::getsockopt(descriptor, SOL_SOCKET, SO_DOMAIN, &family, &size);
  const unsigned ended = POLLHUP | POLLERR | (family == AF_UNIX ? 0U : unsigned{POLLRDHUP});
  pollfd asked{descriptor, POLLRDHUP, 0};
  return ::poll(&asked, 1, 0) > 0 && (static_cast<unsigned>(asked.revents) & ended) != 0;
}

}  // namespace

void StreamReaders::wake() {
  std::erase_if(readers_, [](const auto& held) { return held.expired(); });
  for (const auto& held : readers_) {
    held.lock()->news.cancel();
  }
}

// A client that closes would be noticed with the next comment; until then it would keep another one
// out.
void StreamReaders::watch(ControlStream& stream, const std::shared_ptr<Reader>& reader) {
  stream.socket().async_wait(
      boost::asio::socket_base::wait_read,
      [held = std::weak_ptr(reader), &stream](const boost::system::error_code& error) {
        // As long as the reader is there, so is its connection, though perhaps closed by us.
        const auto reading = held.lock();
        std::array<char, 256> ignored{};
        if (reading &&
            (error || !stream.socket().is_open() || is_closed(stream.socket().native_handle()))) {
          reading->has_gone = true;
          reading->news.cancel();
        } else if (reading && ::recv(stream.socket().native_handle(), ignored.data(),
                                     ignored.size(), MSG_DONTWAIT) > 0) {
          watch(stream, reading);
        }
      });
}

// What is new may be nothing for this reader: then it waits on.
boost::asio::awaitable<std::string> StreamReaders::wait_for_news(
    Reader& reader, const std::function<std::string()>& next) {
  const auto until = std::chrono::steady_clock::now() + kCommentInterval;
  std::string text;
  while (text.empty() && !reader.has_gone && std::chrono::steady_clock::now() < until) {
    reader.news.expires_at(until);
    co_await reader.news.async_wait(io::kAsTuple);
    text = next();
  }
  co_return text;
}

boost::asio::awaitable<void> StreamReaders::feed(ControlStream& stream,
                                                 std::function<std::string()> next) {
  const auto reader = std::make_shared<Reader>(stream.get_executor());
  readers_.emplace_back(reader);
  watch(stream, reader);
  std::string text(kStreamHead);
  while (!reader->has_gone) {
    stream.expires_after(kClientLimit);
    const auto [error, sent] =
        co_await boost::asio::async_write(stream, boost::asio::buffer(text), io::kAsTuple);
    if (error) {
      break;
    }
    text = next();
    if (text.empty()) {
      text = co_await wait_for_news(*reader, next);
    }
    if (text.empty()) {
      text = kComment;
    }
  }
}

}  // namespace mbgate::app
