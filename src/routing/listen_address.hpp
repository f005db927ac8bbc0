// SPDX-License-Identifier: Apache-2.0
// An address of this machine with a TCP port, as a person writes it: "127.0.0.1:8080",
// "[::1]:8080".
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "routing/client_address.hpp"

namespace mbgate::routing {

struct ListenAddress {
  ClientAddress address;
  std::uint16_t port = 0;  ///< 0: the kernel chooses
  /// Nothing if it is no address with a port; IPv6, and it alone, stands in brackets.
  static std::optional<ListenAddress> parse(std::string_view text);
  friend bool operator==(const ListenAddress&, const ListenAddress&) = default;
};

/// What only this machine itself reaches (RFC 1122, 3.2.1.3; RFC 4291, 2.5.3).
NetworkList loopback_networks();
bool is_loopback(const ClientAddress& address);

}  // namespace mbgate::routing
