// SPDX-License-Identifier: Apache-2.0
#include "app/control/tcp_rules.hpp"

#include <algorithm>
#include <cctype>
#include <fmt/core.h>

#include "app/control/control_answers.hpp"
#include "app/text.hpp"
#include "routing/client_address.hpp"

namespace mbgate::app {
namespace {

namespace http = boost::beast::http;

constexpr unsigned kVersionWithoutHost = 10;  // HTTP/1.0

std::string in_small_letters(std::string_view name) {
  std::string small(name);
  std::ranges::transform(small, small.begin(), [](char letter) {
    return static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
  });
  return small;
}

/// "[::1]:8080" is "::1", "Gateway:80" is "gateway".
std::string without_port(std::string_view host) {
  if (host.starts_with('[')) {
    const auto end = host.find(']');
    return std::string(host.substr(1, end == std::string_view::npos ? end : end - 1));
  }
  return in_small_letters(host.substr(0, host.find(':')));
}

Refusal foreign(std::string_view from, const char* header) {
  return {http::status::forbidden,
          fmt::format("the request comes from a page of another origin, \"{}\" ({})",
                      valid_utf8(from), header)};
}

/// Does somebody go to the status page by a link elsewhere? It is shown to nobody but that person.
bool is_link_to_page(const http::request_header<>& request) {
  return request.method() == http::verb::get && request.target() == "/" &&
         request["Sec-Fetch-Mode"] == "navigate" && request["Sec-Fetch-Dest"] == "document";
}

bool is_stream(std::string_view target) {
  return target.starts_with("/api/v1/events") || target.starts_with("/api/v1/trace");
}

/// Browsers do not say of every page (Sec-Fetch-Site) whose it is; what an image or a script of one
/// is asked for, they do not call an event stream.
bool is_stream_for_no_reader(const http::request_header<>& request) {
  return is_stream(path_of(request)) && request[http::field::user_agent].starts_with("Mozilla/") &&
         request[http::field::accept].find("text/event-stream") == boost::beast::string_view::npos;
}

/// Over either kind of socket.
std::optional<Refusal> refused_everywhere(const http::request_header<>& request) {
  const auto hosts = request.count(http::field::host);
  if (hosts > 1 || (hosts == 0 && request.version() > kVersionWithoutHost)) {
    return Refusal{http::status::bad_request, fmt::format("expected one Host, found {}", hosts)};
  }
  const auto site = value_of(request, "Sec-Fetch-Site");
  if (site && *site != "same-origin" && *site != "none" && !is_link_to_page(request)) {
    return foreign(*site, "Sec-Fetch-Site");
  }
  if (is_stream_for_no_reader(request)) {
    return Refusal{
        http::status::not_acceptable,
        "a browser can follow this only as an EventSource: expected text/event-stream in Accept"};
  }
  return std::nullopt;
}

}  // namespace

bool is_own_host(std::string_view host, const std::vector<std::string>& hosts) {
  const std::string name = without_port(host);
  return name == "localhost" || routing::ClientAddress::parse(name) ||
         std::ranges::find(hosts, name) != hosts.end();
}

bool is_same_origin(std::string_view origin, std::string_view host) {
  for (const std::string_view scheme : {"http://", "https://"}) {
    if (origin.starts_with(scheme)) {
      return in_small_letters(origin.substr(scheme.size())) == in_small_letters(host);
    }
  }
  return false;
}

std::optional<Refusal> refused_over_socket(const http::request_header<>& request) {
  if (const auto origin = value_of(request, http::field::origin)) {
    return foreign(*origin, "Origin");
  }
  return refused_everywhere(request);
}

std::optional<Refusal> refused_over_tcp(const http::request_header<>& request,
                                        const std::vector<std::string>& hosts) {
  if (request.method() == http::verb::post) {
    return Refusal{http::status::forbidden,
                   "expected the Unix socket ([http] socket): nothing can be changed over TCP"};
  }
  // What has none is HTTP/1.0, and comes from no browser.
  const auto host = value_of(request, http::field::host);
  if (host && !is_own_host(*host, hosts)) {
    return Refusal{http::status::misdirected_request,
                   fmt::format("\"{}\" is not a name of this machine: use its address, or add the "
                               "name to [http] hosts",
                               valid_utf8(*host))};
  }
  const auto origin = value_of(request, http::field::origin);
  if (origin && !(host && is_same_origin(*origin, *host))) {
    return foreign(*origin, "Origin");
  }
  return refused_everywhere(request);
}

}  // namespace mbgate::app
