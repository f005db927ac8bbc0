// SPDX-License-Identifier: Apache-2.0

#include "modbus/checksum.hpp"

#include <array>
#include <numeric>

namespace mbgate::modbus {

namespace {

constexpr std::array<std::uint16_t, 256> make_table() {
  std::array<std::uint16_t, 256> table{};
  for (unsigned byte = 0; byte < table.size(); ++byte) {
    unsigned value = byte;
    for (int bit = 0; bit < 8; ++bit) {
      value = (value & 1U) != 0 ? (value >> 1U) ^ 0xA001U : value >> 1U;
    }
    table[byte] = static_cast<std::uint16_t>(value);
  }
  return table;
}

constexpr auto kTable = make_table();

}  // namespace

std::uint16_t crc16(Bytes bytes) {
  unsigned crc = 0xFFFF;
  for (const std::uint8_t byte : bytes) {
    crc = (crc >> 8U) ^ kTable[(crc ^ byte) & 0xFFU];
  }
  return static_cast<std::uint16_t>(crc);
}

std::uint8_t lrc(Bytes bytes) {
  const unsigned sum = std::accumulate(bytes.begin(), bytes.end(), 0U);
  return static_cast<std::uint8_t>(0U - sum);
}

}  // namespace mbgate::modbus
