// SPDX-License-Identifier: Apache-2.0
#include "explore/ledger.hpp"

namespace mbgate::explore {
namespace {

std::uint8_t high(unsigned value) { return static_cast<std::uint8_t>(value >> 8U & 0xFFU); }
std::uint8_t low(unsigned value) { return static_cast<std::uint8_t>(value & 0xFFU); }

}  // namespace

Octets pdu_of(Word word, std::uint16_t value) {
  switch (word) {
    case Word::read_a: return {0x03, high(kRegisterA), low(kRegisterA), 0, 2};
    case Word::read_b: return {0x03, high(kRegisterB), low(kRegisterB), 0, 2};
    case Word::write:
      return {0x10, high(kCommand), low(kCommand), 0, 1, 2, high(value), low(value)};
    case Word::stop:
      return {0x10, high(kCommand), low(kCommand), 0, 1, 2, high(kStopValue), low(kStopValue)};
  }
  return {};
}

Octets answer_of(const Flight& flight) {
  const auto address = static_cast<std::uint8_t>(flight.device + 1U);
  if (!Ask{.word = flight.word}.is_read()) {
    return world::rtu_frame(address, Octets{0x10, high(kCommand), low(kCommand), 0, 1});
  }
  const unsigned tag = tag_of(flight.device, flight.word);
  return world::rtu_frame(
      address, Octets{0x03, 4, high(flight.serial), low(flight.serial), high(tag), low(tag)});
}

bool looks_alike(Word a, Word b) { return Ask{.word = a}.is_read() == Ask{.word = b}.is_read(); }

std::string_view name_of(Word word) {
  switch (word) {
    case Word::read_a: return "read A";
    case Word::read_b: return "read B";
    case Word::write: return "write";
    case Word::stop: return "stop";
  }
  return "";
}

std::string name_of(const Ask& ask) {
  return std::string(name_of(ask.word)) + " of device " + std::to_string(ask.device + 1) +
         " by client " + std::to_string(ask.client + 1);
}

}  // namespace mbgate::explore
