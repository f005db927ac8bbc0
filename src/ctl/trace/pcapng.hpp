// SPDX-License-Identifier: Apache-2.0
// The blocks of a capture file that Wireshark reads (draft-ietf-opsawg-pcapng): a section, its
// interfaces, and packets with instants in microseconds. Little-endian on every machine.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "ctl/trace/trace_event.hpp"
#include "modbus/bytes.hpp"

namespace mbgate::ctl {

enum class LinkType : std::uint16_t {
  raw_ip = 101,    ///< an IPv4 or IPv6 packet
  upper_pdu = 252  ///< tags that name a dissector, then what it gets
};

/// As the gateway sees it.
enum class Heading : std::uint8_t { inbound = 1, outbound = 2 };

struct CapturedPacket {
  TraceInstant at;
  Heading heading = Heading::inbound;
  ByteString bytes;
  std::string comment{};  ///< empty: none
};

/// The first block. `application`: what has written the file.
ByteString section_block(const std::string& application);

/// The first interface of a section has the number 0, the next 1, and so on.
ByteString interface_block(LinkType type, const std::string& name, const std::string& description);

/// `interface`: the number of one whose block comes before.
ByteString packet_block(std::uint32_t interface, const CapturedPacket& packet);

/// TCP segments made up around what a client and the gateway said, with the checksums that they
/// need: IPv4 (RFC 791), IPv6 (RFC 8200), TCP (RFC 9293).
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
