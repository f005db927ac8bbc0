// SPDX-License-Identifier: Apache-2.0
// Bytes as every module passes them: a view, and big-endian fields inside one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace mbgate::modbus {

/// A view of bytes that somebody else owns.
using Bytes = std::span<const std::uint8_t>;

/// The 16-bit big-endian field at `offset`; the caller has checked the size (Application Protocol
/// V1.1b3, 4.2).
inline std::uint16_t load_be16(Bytes bytes, std::size_t offset) {
  return static_cast<std::uint16_t>((bytes[offset] << 8U) | bytes[offset + 1]);
}

/// Writes a 16-bit big-endian field at `offset`; the caller has checked the size.
inline void store_be16(std::span<std::uint8_t> bytes, std::size_t offset, std::uint16_t value) {
  bytes[offset] = static_cast<std::uint8_t>(value >> 8U);
  bytes[offset + 1] = static_cast<std::uint8_t>(value & 0xFFU);
}

}  // namespace mbgate::modbus
