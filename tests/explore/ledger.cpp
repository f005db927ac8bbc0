// SPDX-License-Identifier: Apache-2.0
#include "explore/ledger.hpp"

namespace mbgate::explore {

using world::high;
using world::low;

Octets pdu_of(Word word, std::uint16_t value) {
  switch (word) {
    case Word::read_a: return world::request(0x03, kRegisterA, 2);
    case Word::read_b: return world::request(0x03, kRegisterB, 2);
    case Word::write:
      return {0x10, high(kCommand), low(kCommand), 0, 1, 2, high(value), low(value)};
    case Word::stop: return pdu_of(Word::write, kStopValue);
  }
  return {};
}

Octets answer_of(const Flight& flight) {
  const auto address = static_cast<std::uint8_t>(flight.device + 1U);
  if (!Ask{.word = flight.word}.is_read()) {
    return world::rtu_frame(address, world::request(0x10, kCommand, 1));
  }
  const unsigned tag = tag_of(flight.device, flight.word);
  return world::rtu_frame(
      address, Octets{0x03, 4, high(flight.serial), low(flight.serial), high(tag), low(tag)});
}

bool looks_alike(Word a, Word b) { return Ask{.word = a}.is_read() == Ask{.word = b}.is_read(); }

std::string name_of(const Ask& ask) {
  constexpr std::array<const char*, kWords> kNames{"read A", "read B", "write", "stop"};
  return std::string(kNames.at(static_cast<std::size_t>(ask.word))) + " of device " +
         std::to_string(ask.device + 1) + " by client " + std::to_string(ask.client + 1);
}

}  // namespace mbgate::explore
