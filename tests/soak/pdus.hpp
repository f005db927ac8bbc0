// SPDX-License-Identifier: Apache-2.0
// Requests, put together byte by byte and by nothing of the product.
#pragma once

#include <string>
#include <vector>

#include "soak/asked.hpp"

namespace mbgate::soak {

constexpr std::uint8_t high(unsigned value) {
  return static_cast<std::uint8_t>(value >> 8U & 0xFFU);
}
constexpr std::uint8_t low(unsigned value) { return static_cast<std::uint8_t>(value & 0xFFU); }

inline PduBytes fields(unsigned function, unsigned first, unsigned second) {
  return {low(function), high(first), low(first), high(second), low(second)};
}

inline void append_word(PduBytes& pdu, unsigned word) {
  pdu.push_back(high(word));
  pdu.push_back(low(word));
}

inline void append_words(PduBytes& pdu, const std::vector<std::uint16_t>& words) {
  pdu.push_back(low(static_cast<unsigned>(words.size() * 2)));
  for (const std::uint16_t word : words) {
    append_word(pdu, word);
  }
}

inline std::string hex(modbus::Bytes bytes) {
  constexpr char kDigits[] = "0123456789ABCDEF";
  std::string text;
  for (const std::uint8_t byte : bytes) {
    text += {kDigits[byte >> 4U], kDigits[byte & 15U]};
  }
  return text;
}

/// 16.
inline PduBytes multiple_pdu(unsigned first, const std::vector<std::uint16_t>& words) {
  PduBytes pdu = fields(0x10, first, static_cast<unsigned>(words.size()));
  append_words(pdu, words);
  return pdu;
}

inline constexpr unsigned kWordOfCoils = 16;
inline constexpr unsigned kOn = 0xFF00;  ///< of a coil

/// 15.
inline PduBytes coils_pdu(unsigned first, const std::vector<std::uint16_t>& words) {
  PduBytes pdu = fields(0x0F, first, static_cast<unsigned>(words.size()) * kWordOfCoils);
  pdu.push_back(low(static_cast<unsigned>(words.size() * 2)));
  for (const std::uint16_t word : words) {
    pdu.push_back(low(word));  // the first coil is the lowest bit of the first byte
    pdu.push_back(high(word));
  }
  return pdu;
}

inline PduBytes one_of_coils(unsigned address) {
  return {0x0F, high(address), low(address), 0, 1, 1, 1};
}

/// Of a counter, so that no two are alike.
constexpr std::uint16_t scattered(std::uint16_t counter) {
  constexpr unsigned kOdd = 40503;
  return static_cast<std::uint16_t>(counter * kOdd);
}

inline Asked begin(const Door& door, Kind kind) {
  Asked asked;
  asked.kind = kind;
  asked.door = &door;
  asked.unit = door.unit;
  return asked;
}

}  // namespace mbgate::soak
