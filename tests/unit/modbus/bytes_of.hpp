// SPDX-License-Identifier: Apache-2.0
// Bytes in tests as people read them: bytes_of("01 03 00 1E"). A typing error throws
// std::invalid_argument.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "modbus/pdu.hpp"

namespace mbgate::modbus {

/// Two hexadecimal digits a byte, one space between.
inline std::vector<std::uint8_t> bytes_of(std::string_view hex) {
  std::vector<std::uint8_t> bytes;
  for (std::size_t at = 0; at < hex.size(); at += 3) {
    const std::string digits(hex.substr(at, 2));
    std::size_t used = 0;
    const unsigned long value = std::stoul(digits, &used, 16);
    if (used != 2 || (at + 2 < hex.size() && hex[at + 2] != ' ')) {
      throw std::invalid_argument("not bytes: " + std::string(hex));
    }
    bytes.push_back(static_cast<std::uint8_t>(value));
  }
  return bytes;
}

/// `head` followed by `count` bytes of `fill`.
inline std::vector<std::uint8_t> bytes_of(std::string_view head, std::size_t count,
                                          std::uint8_t fill) {
  std::vector<std::uint8_t> bytes = bytes_of(head);
  bytes.insert(bytes.end(), count, fill);
  return bytes;
}

/// A PDU of bytes that the test knows to be 1 to 253.
inline Pdu pdu_of(const std::vector<std::uint8_t>& bytes) { return Pdu::from(bytes).value(); }
inline Pdu pdu_of(std::string_view hex) { return pdu_of(bytes_of(hex)); }

}  // namespace mbgate::modbus
