// SPDX-License-Identifier: Apache-2.0
// TCP segments made up around what a client and the gateway said, with the checksums that they
// need: IPv4 (RFC 791), IPv6 (RFC 8200), TCP (RFC 9293).
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "ctl/trace/trace_event.hpp"
#include "modbus/bytes.hpp"

namespace mbgate::ctl {

struct TcpEndpoint {
  ByteString address;  ///< 4 or 16 octets
  std::uint16_t port = 0;
};

/// The octets of "192.0.2.7" or "2001:db8::7"; nothing for another text.
std::optional<ByteString> ip_octets(const std::string& text);

/// Positions in the two streams of a connection.
struct TcpPlace {
  std::uint32_t sequence = 0;      ///< of the first byte that is sent
  std::uint32_t acknowledged = 0;  ///< the next byte that is expected
};

/// An IP packet with a segment that carries `data`. Both endpoints have addresses of one kind.
ByteString tcp_segment(const TcpEndpoint& from, const TcpEndpoint& to, TcpPlace place,
                       modbus::Bytes data);

}  // namespace mbgate::ctl
