// SPDX-License-Identifier: Apache-2.0
// Resolves the host of a TCP bus to the addresses to be tried.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bus/settings.hpp"
#include "modbus/result.hpp"

namespace mbgate::io {

/// The most addresses of a host that are tried: further ones would only delay the report that it
/// cannot be reached.
inline constexpr std::size_t kMaxHostAddresses = 4;

using HostAddresses = std::vector<boost::asio::ip::tcp::endpoint>;

/// The name of the server in messages: "tcp://drive.plant:502", "tcp://[::1]:502".
std::string to_text(const bus::Endpoint& remote);

/// The address of the server; nothing if the host is a name and not an IPv4 or IPv6 address.
std::optional<boost::asio::ip::tcp::endpoint> numeric_endpoint(const bus::Endpoint& remote);

/// Asks the system's resolver, which may block while the name servers do not answer. The addresses
/// are in the resolver's order of preference, kMaxHostAddresses at most. The error says why there
/// is none.
Result<HostAddresses, std::string> resolve(const bus::Endpoint& remote);

}  // namespace mbgate::io
