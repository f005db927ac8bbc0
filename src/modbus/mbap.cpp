// SPDX-License-Identifier: Apache-2.0
#include "modbus/mbap.hpp"

#include <algorithm>
#include <array>

#include "modbus/frames.hpp"

namespace mbgate::modbus {
namespace {

constexpr std::uint16_t kMinLength = 2;    // unit identifier and function code
constexpr std::uint16_t kMaxLength = 254;  // unit identifier and 253 bytes
constexpr std::size_t kLengthFieldEnd = 6;

}  // namespace

MbapBytes encode(const MbapAdu& adu) {
  std::array<std::uint8_t, kMbapHeaderSize> header{};
  store_be16(header, 0, adu.header.transaction);
  store_be16(header, 4, static_cast<std::uint16_t>(adu.pdu.size() + 1));
  header[6] = adu.header.unit;
  MbapBytes bytes(header.begin(), header.end());
  const Bytes pdu = adu.pdu.bytes();
  bytes.insert(bytes.end(), pdu.begin(), pdu.end());
  return bytes;
}

MbapScan scan_mbap(Bytes stream) {
  if (stream.size() < kLengthFieldEnd) {
    return MbapIncomplete{};
  }
  const std::uint16_t length = load_be16(stream, 4);
  if (length < kMinLength || length > kMaxLength) {
    return MbapLost{length};
  }
  const std::size_t size = kLengthFieldEnd + length;
  if (stream.size() < size) {
    return MbapIncomplete{};
  }
  if (const std::uint16_t protocol = load_be16(stream, 2); protocol != 0) {
    return MbapForeign{protocol, size};
  }
  const MbapHeader header{load_be16(stream, 0), stream[6]};
  // A length of 2 to 254 leaves 1 to 253 bytes of PDU.
  return MbapFrame{{header, *Pdu::from(stream.subspan(kMbapHeaderSize, length - 1U))}, size};
}

MbapScan scan_mbap_answer(Bytes stream) {
  if (stream.size() <= kMbapHeaderSize) {
    return MbapIncomplete{};  // the smallest answer has a function code
  }
  if (load_be16(stream, 2) != 0 || (stream[kMbapHeaderSize] & kExceptionBit) == 0) {
    return scan_mbap(stream);
  }
  constexpr std::size_t kSize = kMbapHeaderSize + 2;
  if (stream.size() < kSize) {
    return MbapIncomplete{};
  }
  const MbapHeader header{load_be16(stream, 0), stream[6]};
  return MbapFrame{{header, *Pdu::from(stream.subspan(kMbapHeaderSize, 2))}, kSize};
}

bool looks_like_rtu(Bytes stream) {
  if (stream.size() < kMinRtuSize || !is_request_function(stream[1])) {
    return false;
  }
  const auto good_crc = [&](std::size_t size) {
    return stream.size() >= size && has_good_crc(stream.first(size));
  };
  const bool multiple = stream[1] == 0x0F || stream[1] == 0x10;
  const std::size_t guess = multiple && stream.size() > 6 ? std::size_t{9} + stream[6] : 8;
  return good_crc(guess) || good_crc(std::min(stream.size(), kMaxRtuSize));
}

std::string_view other_protocol(Bytes stream) {
  if (stream.size() >= 2 && stream[0] == 0x16 && stream[1] == 0x03) {
    return "TLS";
  }
  if (!stream.empty() && stream[0] == ':') {
    return "Modbus ASCII";
  }
  const auto is_capital = [](std::uint8_t byte) { return byte >= 'A' && byte <= 'Z'; };
  const auto space = std::ranges::find_if_not(stream, is_capital);
  const bool is_method = space - stream.begin() >= 3 && space != stream.end() && *space == ' ';
  return is_method ? "HTTP" : "";
}

}  // namespace mbgate::modbus
