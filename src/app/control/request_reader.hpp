// SPDX-License-Identifier: Apache-2.0
// Reads the requests of one connection within bounds: a request that does not end is refused, and
// none takes more memory than kMostHeld. No request needs a body; a short one is read and ignored,
// because some clients send "{}".
#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "app/control/stream_readers.hpp"
#include "app/control/tcp_rules.hpp"

namespace mbgate::app {

class RequestReader {
 public:
  static constexpr std::uint32_t kLongestHeader = 8192;
  static constexpr std::uint32_t kLongestBody = 4096;
  /// Of what was sent and is not understood yet. A chunk's extension and trailers count as well,
  /// for which a parser has no limit of its own.
  static constexpr std::size_t kMostHeld = kLongestHeader + kLongestBody;

  struct Incoming {
    boost::beast::http::request<boost::beast::http::string_body> request;
    /// Why it, or its body, is not read. Nothing can be read after it.
    std::optional<Refusal> refusal;
  };

  explicit RequestReader(ControlStream& stream) : stream_(stream) {}

  /// Nothing: it has ended, or took too long.
  boost::asio::awaitable<std::optional<Incoming>> read();

 private:
  ControlStream& stream_;
  boost::beast::flat_buffer buffer_{kMostHeld};
};

}  // namespace mbgate::app
