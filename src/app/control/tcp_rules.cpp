// SPDX-License-Identifier: Apache-2.0
#include "app/control/tcp_rules.hpp"

#include <algorithm>
#include <cctype>

#include "app/utf8.hpp"
#include "routing/client_address.hpp"

namespace mbgate::app {
namespace {

namespace http = boost::beast::http;

/// "[::1]:8080" is "::1", "Gateway:80" is "gateway".
std::string without_port(std::string_view host) {
  if (host.starts_with('[')) {
    const auto end = host.find(']');
    return std::string(host.substr(1, end == std::string_view::npos ? end : end - 1));
  }
  std::string name(host.substr(0, host.find(':')));
  std::ranges::transform(name, name.begin(), [](char letter) {
    return static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
  });
  return name;
}

}  // namespace

bool is_own_host(std::string_view host, const std::vector<std::string>& hosts) {
  const std::string name = without_port(host);
  return name == "localhost" || routing::ClientAddress::parse(name) ||
         std::ranges::find(hosts, name) != hosts.end();
}

std::optional<Refusal> refused_over_tcp(const http::request_header<>& request,
                                        const std::vector<std::string>& hosts) {
  if (request.method() == http::verb::post) {
    return Refusal{http::status::forbidden,
                   "only on the Unix socket, [http] socket: nothing is changed over TCP"};
  }
  // What has none comes from no browser.
  const auto found = request.find(http::field::host);
  if (found == request.end()) {
    return std::nullopt;
  }
  const std::string_view host(found->value().data(), found->value().size());
  if (is_own_host(host, hosts)) {
    return std::nullopt;
  }
  return Refusal{http::status::misdirected_request,
                 "this machine does not go by the name \"" + valid_utf8(host) +
                     "\": ask for its address, or add the name to [http] hosts"};
}

}  // namespace mbgate::app
