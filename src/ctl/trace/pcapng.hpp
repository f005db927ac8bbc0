// SPDX-License-Identifier: Apache-2.0
// The blocks of a capture file that Wireshark reads (draft-ietf-opsawg-pcapng): a section, its
// interfaces, and packets with instants in microseconds. Little-endian on every machine.
#pragma once

#include <cstdint>
#include <string>

#include "ctl/trace/trace_event.hpp"

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
  std::string comment;  ///< empty: none
};

/// The first block. `application`: what has written the file.
ByteString section_block(const std::string& application);

/// The first interface of a section has the number 0, the next 1, and so on.
ByteString interface_block(LinkType type, const std::string& name, const std::string& description);

/// `interface`: the number of one whose block comes before.
ByteString packet_block(std::uint32_t interface, const CapturedPacket& packet);

}  // namespace mbgate::ctl
