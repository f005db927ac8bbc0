// SPDX-License-Identifier: Apache-2.0
// "host:port", "[::1]:port": an IPv6 address stands in brackets, and nothing else does.
#pragma once

#include <cstdint>
#include <fmt/core.h>
#include <optional>
#include <string>
#include <string_view>

#include "base/text.hpp"

namespace mbgate {

struct HostAndPort {
  std::string host;
  std::uint16_t port;
};

inline std::optional<HostAndPort> host_and_port(std::string_view text) {
  const auto colon = text.rfind(':');
  if (colon == std::string_view::npos) {
    return std::nullopt;
  }
  auto host = text.substr(0, colon);
  const bool is_bracketed = host.starts_with('[') && host.ends_with(']');
  if (is_bracketed) {
    host = host.substr(1, host.size() - 2);
  }
  const auto port = integer_in<std::uint16_t>(text.substr(colon + 1));
  if (!port || is_bracketed != (host.find(':') != std::string_view::npos)) {
    return std::nullopt;
  }
  return HostAndPort{std::string(host), *port};
}

/// The same of a server: its port is not 0, its host a name or an address.
inline std::optional<HostAndPort> server_in(std::string_view text) {
  auto server = host_and_port(text);
  const bool is_one = server && server->port != 0 && !server->host.empty() &&
                      server->host.find_first_of("/[]@ ") == std::string::npos;
  return is_one ? server : std::nullopt;
}

inline std::string host_and_port(std::string_view host, std::uint16_t port) {
  return host.find(':') == std::string_view::npos ? fmt::format("{}:{}", host, port)
                                                  : fmt::format("[{}]:{}", host, port);
}

}  // namespace mbgate
