// SPDX-License-Identifier: Apache-2.0
#include "app/control/request_reader.hpp"

#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <fmt/core.h>
#include <utility>

#include "io/supervise.hpp"

namespace mbgate::app {
namespace {

namespace http = boost::beast::http;
using Parser = http::request_parser<http::string_body>;

/// Nothing where the client has gone, or was too slow.
std::optional<Refusal> refused_head(const boost::system::error_code& error) {
  if (error == http::error::header_limit || error == http::error::buffer_overflow) {
    return Refusal{
        http::status::request_header_fields_too_large,
        fmt::format("expected a header of at most {} bytes", RequestReader::kLongestHeader)};
  }
  if (error.category() != boost::system::error_code(http::error::bad_method).category() ||
      error == http::error::end_of_stream || error == http::error::partial_message) {
    return std::nullopt;
  }
  return Refusal{http::status::bad_request, "expected HTTP: " + error.message()};
}

std::optional<Refusal> refused_body(const Parser& parser) {
  if (parser.chunked()) {
    return Refusal{http::status::length_required,
                   "expected no body, found one without a length (Transfer-Encoding)"};
  }
  if (parser.content_length().value_or(0) > RequestReader::kLongestBody) {
    return Refusal{http::status::payload_too_large,
                   fmt::format("expected no body, found one of more than {} bytes",
                               RequestReader::kLongestBody)};
  }
  return std::nullopt;
}

}  // namespace

boost::asio::awaitable<std::optional<RequestReader::Incoming>> RequestReader::read() {
  Parser parser;
  parser.header_limit(kLongestHeader);
  parser.body_limit(boost::none);  // refused_body() looks at it, and says so
  stream_.expires_after(kClientLimit);
  const auto [head_error, head_size] =
      co_await http::async_read_header(stream_, buffer_, parser, io::kAsTuple);
  if (auto refusal = head_error ? refused_head(head_error) : refused_body(parser)) {
    co_return Incoming{parser.release(), std::move(refusal)};
  }
  if (head_error) {
    co_return std::nullopt;
  }
  const auto [error, size] = co_await http::async_read(stream_, buffer_, parser, io::kAsTuple);
  if (error) {
    co_return std::nullopt;
  }
  co_return Incoming{parser.release(), std::nullopt};
}

}  // namespace mbgate::app
