// SPDX-License-Identifier: Apache-2.0
#include "ctl/trace/segment.hpp"

#include <arpa/inet.h>

#include <array>

namespace mbgate::ctl {
namespace {

constexpr std::size_t kIpv4Octets = 4;
constexpr std::size_t kIpv6Octets = 16;
constexpr std::uint8_t kTcp = 6;
constexpr std::uint8_t kHops = 64;
constexpr std::size_t kTcpHeader = 20;

void append16(ByteString& bytes, std::uint32_t number) {
  bytes.push_back(static_cast<std::uint8_t>(number >> 8U));
  bytes.push_back(static_cast<std::uint8_t>(number));
}

void append32(ByteString& bytes, std::uint32_t number) {
  append16(bytes, number >> 16U);
  append16(bytes, number);
}

void append(ByteString& bytes, modbus::Bytes more) {
  bytes.insert(bytes.end(), more.begin(), more.end());
}

/// Of the Internet (RFC 1071): the complement of the sum of all 16-bit words.
std::uint16_t internet_checksum(modbus::Bytes bytes) {
  std::uint32_t sum = 0;
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    sum += at % 2 == 0 ? bytes[at] * 0x100U : bytes[at];
  }
  while (sum > 0xFFFF) {
    sum = (sum & 0xFFFFU) + (sum >> 16U);
  }
  return static_cast<std::uint16_t>(~sum);
}

ByteString ip_header(const TcpEndpoint& from, const TcpEndpoint& to, std::size_t carried) {
  ByteString header;
  if (from.address.size() == kIpv6Octets) {
    append32(header, 0x60000000);  // version 6
    append16(header, static_cast<std::uint32_t>(carried));
    append(header, std::to_array({kTcp, kHops}));
    append(header, from.address);
    append(header, to.address);
    return header;
  }
  constexpr std::size_t kHeader = 20;
  constexpr std::size_t kChecksumAt = 10;
  append16(header, 0x4500);  // version 4, five words
  append16(header, static_cast<std::uint32_t>(kHeader + carried));
  append32(header, 0x4000);  // not to be fragmented
  append(header, std::to_array({kHops, kTcp}));
  append16(header, 0);
  append(header, from.address);
  append(header, to.address);
  modbus::store_be16(header, kChecksumAt, internet_checksum(header));
  return header;
}

}  // namespace

std::optional<ByteString> ip_octets(const std::string& text) {
  ByteString octets(kIpv6Octets);
  if (::inet_pton(AF_INET, text.c_str(), octets.data()) == 1) {
    octets.resize(kIpv4Octets);
    return octets;
  }
  if (::inet_pton(AF_INET6, text.c_str(), octets.data()) == 1) {
    return octets;
  }
  return std::nullopt;
}

ByteString tcp_segment(const TcpEndpoint& from, const TcpEndpoint& to, TcpPlace place,
                       modbus::Bytes data) {
  constexpr std::size_t kChecksumAt = 16;
  ByteString tcp;
  append16(tcp, from.port);
  append16(tcp, to.port);
  append32(tcp, place.sequence);
  append32(tcp, place.acknowledged);
  append16(tcp, 0x5018);  // five words; pushed, acknowledges
  append16(tcp, 0xFFFF);  // window
  append32(tcp, 0);       // checksum, and nothing urgent
  append(tcp, data);

  ByteString covered = from.address;  // with the pseudo header
  append(covered, to.address);
  append32(covered, static_cast<std::uint32_t>(tcp.size()));
  append32(covered, kTcp);
  append(covered, tcp);
  modbus::store_be16(tcp, kChecksumAt, internet_checksum(covered));

  ByteString packet = ip_header(from, to, kTcpHeader + data.size());
  append(packet, tcp);
  return packet;
}

}  // namespace mbgate::ctl
