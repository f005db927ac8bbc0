// SPDX-License-Identifier: Apache-2.0
// From the host of a TCP bus to the addresses to be tried.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bus/settings.hpp"
#include "modbus/result.hpp"

namespace mbgate::io {

/// No more of a host's addresses are tried: the others would only delay the news that it is not
/// there.
inline constexpr std::size_t kMaxHostAddresses = 4;

using HostAddresses = std::vector<boost::asio::ip::tcp::endpoint>;

/// The far end as it is named in texts: "tcp://drive.plant:502", "tcp://[::1]:502".
std::string to_text(const bus::Endpoint& remote);

/// Nothing if the host is a name, no IPv4 or IPv6 address.
std::optional<boost::asio::ip::tcp::endpoint> numeric_endpoint(const bus::Endpoint& remote);

/// Asks the system's resolver, which may block for as long as the name servers are silent. In its
/// order of preference, kMaxHostAddresses at most. The error says why there is none.
Result<HostAddresses, std::string> resolve(const bus::Endpoint& remote);

}  // namespace mbgate::io
