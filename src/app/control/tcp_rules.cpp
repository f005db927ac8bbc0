// SPDX-License-Identifier: Apache-2.0
#include "app/control/tcp_rules.hpp"

#include <algorithm>
#include <cctype>

#include "app/utf8.hpp"
#include "routing/client_address.hpp"

namespace mbgate::app {
namespace {

namespace http = boost::beast::http;

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

std::optional<std::string_view> value_of(const http::request_header<>& request, http::field field) {
  const auto found = request.find(field);
  if (found == request.end()) {
    return std::nullopt;
  }
  return std::string_view(found->value().data(), found->value().size());
}

Refusal foreign_origin(std::string_view origin) {
  return {http::status::forbidden,
          "asked by a page from elsewhere, \"" + valid_utf8(origin) + "\" (Origin)"};
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
    return foreign_origin(*origin);
  }
  return std::nullopt;
}

std::optional<Refusal> refused_over_tcp(const http::request_header<>& request,
                                        const std::vector<std::string>& hosts) {
  if (request.method() == http::verb::post) {
    return Refusal{http::status::forbidden,
                   "only on the Unix socket, [http] socket: nothing is changed over TCP"};
  }
  // What has none comes from no browser.
  const auto host = value_of(request, http::field::host);
  if (host && !is_own_host(*host, hosts)) {
    return Refusal{http::status::misdirected_request,
                   "this machine does not go by the name \"" + valid_utf8(*host) +
                       "\": ask for its address, or add the name to [http] hosts"};
  }
  const auto origin = value_of(request, http::field::origin);
  if (origin && !(host && is_same_origin(*origin, *host))) {
    return foreign_origin(*origin);
  }
  return std::nullopt;
}

}  // namespace mbgate::app
