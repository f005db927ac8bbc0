// SPDX-License-Identifier: Apache-2.0
// Any bytes as a request to the HTTP interface: who is refused, what a page or a stream is asked
// for. Boost.Beast reads the request; what is judged here is what the gateway makes of it.
#include <boost/asio/buffer.hpp>
#include <boost/asio/ip/address.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>
#include <optional>

#include "app/control/event_streams.hpp"
#include "app/control/tcp_rules.hpp"
#include "app/page/page_answer.hpp"
#include "app/text.hpp"
#include "app/trace/trace_json.hpp"
#include "fuzz/fuzz.hpp"

namespace mbgate::fuzz::http_target {
namespace {

namespace http = boost::beast::http;
using HttpRequest = http::request<http::string_body>;

constexpr auto kOwnName = "gateway.plant";

std::optional<HttpRequest> read_request(modbus::Bytes bytes) {
  http::request_parser<http::string_body> parser;
  parser.header_limit(8192);
  parser.body_limit(65536);
  parser.eager(true);
  boost::system::error_code error;
  parser.put(boost::asio::buffer(bytes.data(), bytes.size()), error);
  if (error || !parser.is_done()) {
    return std::nullopt;
  }
  return parser.release();
}

std::string small(std::string_view text) {
  std::string letters(text);
  std::ranges::transform(letters, letters.begin(), [](unsigned char letter) {
    return static_cast<char>(letter >= 'A' && letter <= 'Z' ? letter + ('a' - 'A') : letter);
  });
  return letters;
}

/// The name in a Host, found in another way: from behind, and by Asio's idea of an address.
bool may_mean_this_machine(std::string_view host) {
  std::string name = small(host);
  const std::size_t bracket = name.find(']');
  if (name.starts_with('[')) {
    name = name.substr(1, bracket == std::string::npos ? std::string::npos : bracket - 1);
  } else if (const std::size_t colon = name.find(':'); colon != std::string::npos) {
    name.resize(colon);
  }
  boost::system::error_code error;
  boost::asio::ip::make_address(name, error);
  return !error || name == "localhost" || name == kOwnName;
}

void judge(const HttpRequest& request) {
  const auto refused = app::refused_over_tcp(request, {kOwnName});
  const bool has_host = request.find(http::field::host) != request.end();
  const bool has_origin = request.find(http::field::origin) != request.end();
  require(request.method() != http::verb::post || refused, "nothing is changed over TCP");
  require(has_host || !has_origin || refused, "a page's origin is held to the host");
  require(refused || !has_host || may_mean_this_machine(request[http::field::host]),
          "only by a name of this machine");
  const auto over_socket = app::refused_over_socket(request);
  require(over_socket || !has_origin, "no page reads over the Unix socket");
  require((over_socket && refused) || request.count(http::field::host) < 2, "one host is named");
  for (const auto& refusal : {refused, over_socket}) {
    require(!refusal || (!refusal->why.empty() && app::valid_utf8(refusal->why) == refusal->why),
            "a refusal says why, as text");
    require(!refusal || http::to_status_class(refusal->status) == http::status_class::client_error,
            "it is the client's error");
  }
}

void ask(const HttpRequest& request) {
  const std::string_view target(request.target().data(), request.target().size());
  const std::size_t mark = target.find('?');
  if (const auto page = app::page_answer(request, target.substr(0, mark))) {
    const bool reads = request.method() == http::verb::get || request.method() == http::verb::head;
    require(reads == (page->result() != http::status::method_not_allowed), "a page is read only");
    require(page->count("X-Content-Type-Options") == 1, "nothing is guessed of a page");
  }
  const auto filter = app::TraceFilter::parse(
      mark == std::string_view::npos ? std::string_view() : target.substr(mark + 1));
  require(filter || !filter.error().empty(), "a filter that is none says why");
  if (filter) {
    static_cast<void>(filter->matches(gateway::TraceRecord{}));
  }
  app::EventStreams events(7);
  const auto header = request.find("Last-Event-ID");
  const auto begun = events.begin(
      header == request.end()
          ? std::nullopt
          : std::optional(std::string_view(header->value().data(), header->value().size())));
  require(begun || !begun.error().why.empty(), "a number that is none says why");
}

}  // namespace

MBGATE_FUZZ_TARGET(http) {
  if (const auto request = read_request(modbus::Bytes(data, size))) {
    judge(*request);
    ask(*request);
  }
  return 0;
}

}  // namespace mbgate::fuzz::http_target
