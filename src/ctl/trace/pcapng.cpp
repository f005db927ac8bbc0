// SPDX-License-Identifier: Apache-2.0
#include "ctl/trace/pcapng.hpp"

#include <arpa/inet.h>

#include <array>
#include <string_view>

namespace mbgate::ctl {
namespace {

constexpr std::uint32_t kSection = 0x0A0D0D0A;
constexpr std::uint32_t kInterface = 1;
constexpr std::uint32_t kEnhancedPacket = 6;
constexpr std::uint16_t kEndOfOptions = 0;
constexpr std::uint16_t kComment = 1;
constexpr std::uint16_t kName = 2;
constexpr std::uint16_t kDescription = 3;
constexpr std::uint16_t kFlags = 2;
constexpr std::uint16_t kApplication = 4;
constexpr std::uint16_t kResolution = 9;
/// The length of an option has 16 bits.
constexpr std::size_t kLongestOption = 0xFFFF;

/// The body of a block, as far as it has got.
class BlockBody {
 public:
  void put16(std::uint16_t number) { put(number, 2); }
  void put32(std::uint32_t number) { put(number, 4); }
  void put64(std::uint64_t number) { put(number, 8); }

  /// Followed by zeros up to a multiple of four.
  void put_padded(modbus::Bytes bytes) {
    append(bytes_, bytes);
    bytes_.resize((bytes_.size() + 3) / 4 * 4);
  }

  void put_option(std::uint16_t code, modbus::Bytes value) {
    put16(code);
    put16(static_cast<std::uint16_t>(value.size()));
    put_padded(value);
  }
  void put_option(std::uint16_t code, std::string_view text) {
    text = text.substr(0, kLongestOption);
    put_option(code, ByteString(text.begin(), text.end()));
  }

  /// The whole block: its type, its length before and behind.
  [[nodiscard]] ByteString block(std::uint32_t type) const {
    constexpr std::size_t kAround = 12;
    const auto length = static_cast<std::uint32_t>(bytes_.size() + kAround);
    BlockBody whole;
    whole.put32(type);
    whole.put32(length);
    whole.put_padded(bytes_);
    whole.put32(length);
    return whole.bytes_;
  }

 private:
  void put(std::uint64_t number, unsigned size) {
    for (unsigned byte = 0; byte < size; ++byte) {
      bytes_.push_back(static_cast<std::uint8_t>(number >> (8 * byte)));
    }
  }

  ByteString bytes_;
};

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

ByteString section_block(const std::string& application) {
  constexpr std::uint32_t kByteOrderMagic = 0x1A2B3C4D;
  constexpr std::uint64_t kLengthUnknown = ~std::uint64_t{0};
  BlockBody body;
  body.put32(kByteOrderMagic);
  body.put16(1);  // version 1.0
  body.put16(0);
  body.put64(kLengthUnknown);
  body.put_option(kApplication, application);
  body.put32(kEndOfOptions);
  return body.block(kSection);
}

ByteString interface_block(LinkType type, const std::string& name, const std::string& description) {
  constexpr std::uint8_t kMicroseconds[] = {6};
  BlockBody body;
  body.put16(static_cast<std::uint16_t>(type));
  body.put16(0);
  body.put32(0);  // packets of any size are whole
  body.put_option(kName, name);
  body.put_option(kDescription, description);
  body.put_option(kResolution, kMicroseconds);
  body.put32(kEndOfOptions);
  return body.block(kInterface);
}

ByteString packet_block(std::uint32_t interface, const CapturedPacket& packet) {
  const auto instant = static_cast<std::uint64_t>(packet.at.time_since_epoch().count());
  const auto size = static_cast<std::uint32_t>(packet.bytes.size());
  const std::uint8_t flags[] = {static_cast<std::uint8_t>(packet.heading), 0, 0, 0};
  BlockBody body;
  body.put32(interface);
  body.put32(static_cast<std::uint32_t>(instant >> 32U));
  body.put32(static_cast<std::uint32_t>(instant));
  body.put32(size);  // what was captured
  body.put32(size);  // what there was
  body.put_padded(packet.bytes);
  if (!packet.comment.empty()) {
    body.put_option(kComment, packet.comment);
  }
  body.put_option(kFlags, flags);
  body.put32(kEndOfOptions);
  return body.block(kEnhancedPacket);
}

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
