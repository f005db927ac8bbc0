// SPDX-License-Identifier: Apache-2.0

#include "modbus/checksum.hpp"

#include <array>
#include <numeric>

namespace mbgate::modbus {

namespace {

using CrcTable = std::array<std::uint16_t, 256>;

// What a byte makes of the CRC when so many other bytes have followed it.
constexpr std::array<CrcTable, 4> make_tables() {
  std::array<CrcTable, 4> tables{};
  for (unsigned byte = 0; byte < tables[0].size(); ++byte) {
    unsigned value = byte;
    for (CrcTable& table : tables) {
      for (int bit = 0; bit < 8; ++bit) {
        value = (value & 1U) != 0 ? (value >> 1U) ^ 0xA001U : value >> 1U;
      }
      table[byte] = static_cast<std::uint16_t>(value);
    }
  }
  return tables;
}

constexpr auto kTables = make_tables();

}  // namespace

std::uint16_t crc16(Bytes bytes) {
  unsigned crc = 0xFFFF;
  for (; bytes.size() >= 4; bytes = bytes.subspan(4)) {
    const auto four = bytes.first<4>();
    crc = kTables[3][(crc ^ four[0]) & 0xFFU] ^ kTables[2][(crc >> 8U) ^ four[1]] ^
          kTables[1][four[2]] ^ kTables[0][four[3]];
  }
  for (const std::uint8_t byte : bytes) {
    crc = (crc >> 8U) ^ kTables[0][(crc ^ byte) & 0xFFU];
  }
  return static_cast<std::uint16_t>(crc);
}

std::uint8_t lrc(Bytes bytes) {
  const unsigned sum = std::accumulate(bytes.begin(), bytes.end(), 0U);
  return static_cast<std::uint8_t>(0U - sum);
}

}  // namespace mbgate::modbus
