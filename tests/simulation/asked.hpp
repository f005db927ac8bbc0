// SPDX-License-Identifier: Apache-2.0
// What clients ask for, and the data that belong to it.
#pragma once

#include <vector>

#include "modbus/describe.hpp"
#include "simulation/world.hpp"

namespace mbgate::test {

/// What every register of the test's drives holds, so that an answer tells where it came from.
inline std::uint16_t value_of(std::uint8_t unit, std::uint16_t address) {
  return static_cast<std::uint16_t>(unit * 1000 + address * 7);
}

inline std::vector<std::uint8_t> adu(std::uint16_t transaction, std::uint8_t unit,
                                     const std::vector<std::uint8_t>& pdu) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(7 + pdu.size());
  bytes.push_back(static_cast<std::uint8_t>(transaction >> 8U));
  bytes.push_back(static_cast<std::uint8_t>(transaction & 0xFFU));
  bytes.resize(5);
  bytes.push_back(static_cast<std::uint8_t>(pdu.size() + 1));
  bytes.push_back(unit);
  bytes.insert(bytes.end(), pdu.begin(), pdu.end());
  return bytes;
}

/// Reads `count` registers.
inline std::vector<std::uint8_t> read_pdu(std::uint16_t address, std::uint16_t count) {
  return {0x03, static_cast<std::uint8_t>(address >> 8U),
          static_cast<std::uint8_t>(address & 0xFFU), 0, static_cast<std::uint8_t>(count)};
}

inline std::vector<std::uint8_t> data_pdu(std::uint8_t unit, std::uint16_t address,
                                          std::uint16_t count) {
  std::vector<std::uint8_t> pdu{0x03, static_cast<std::uint8_t>(count * 2)};
  for (unsigned at = 0; at < count; ++at) {
    const std::uint16_t value = value_of(unit, static_cast<std::uint16_t>(address + at));
    pdu.push_back(static_cast<std::uint8_t>(value >> 8U));
    pdu.push_back(static_cast<std::uint8_t>(value & 0xFFU));
  }
  return pdu;
}

}  // namespace mbgate::test
