// SPDX-License-Identifier: Apache-2.0
// The hosts that clients come from: of IPv4 and of IPv6. Each has an address and a network in the
// settings that no other host is in; who is meant by a list is known by the hosts' numbers.
#pragma once

#include <string>
#include <vector>

#include "routing/client_address.hpp"

namespace mbgate::world {

inline constexpr unsigned kMostHosts = 12;

/// Of a client that comes from there.
routing::ClientAddress address_of(unsigned host);
/// As settings name the host: its address, that of IPv4 also as an IPv6 address (RFC
/// 4291, 2.5.5.2), or a network around it.
routing::Network network_of(unsigned host);
/// Its client's address as people write it (RFC 5952, 4).
std::string text_of(unsigned host);
/// All of them, in the settings' words.
routing::NetworkList networks_of(const std::vector<unsigned>& hosts);

}  // namespace mbgate::world
