// SPDX-License-Identifier: Apache-2.0
// Good frames that are not what was asked for: answers with another echo or fewer data, and what
// another client on the line asks.
#include "soak/pdus.hpp"
#include "soak/serial_wire.hpp"

namespace mbgate::soak {
namespace {

constexpr std::uint8_t kFar = 0x40;        // in the high byte of an address: nobody asks for it
constexpr std::uint8_t kStrange = 0x80;    // in the high byte of a value: nobody writes it
constexpr unsigned kOtherFunctions = 600;  // permille of what strangers ask

bool is_read(std::uint8_t function) { return (function >= 1 && function <= 4) || function == 0x17; }

bool is_bits(std::uint8_t function) { return function <= 2; }

}  // namespace

// Of an answer to a write another address, or another value or quantity; of one to a read the last
// register or the last eight bits are missing.
bool SerialWire::make_misfit(std::vector<std::uint8_t>& pdu) {
  const std::uint8_t function = pdu[0];
  const bool repeats =
      function == 5 || function == 6 || function == 0x0F || function == 0x10 || function == 0x16;
  if (repeats && happens_to_echo(rates_.wrong_echo, "wrong_echo")) {
    constexpr std::size_t kAddress = 1;
    constexpr std::size_t kValue = 3;
    if (function == 5) {
      pdu[kValue] ^= 0xFFU;
    } else if (echo_random_.chance(500)) {
      pdu[kAddress] ^= kFar;
    } else {
      pdu[kValue] ^= kStrange;
    }
    return true;
  }
  const std::size_t less = is_bits(function) ? 1 : 2;
  if (is_read(function) && pdu.size() > 2 + less &&
      happens_to_echo(rates_.too_short, "too_short")) {
    pdu.resize(pdu.size() - less);
    pdu[1] = low(static_cast<unsigned>(pdu.size() - 2));
    return true;
  }
  return false;
}

// Of every function. What it writes no client of the gateway writes.
std::vector<std::uint8_t> SerialWire::strange_request() {
  if (!echo_random_.chance(kOtherFunctions)) {
    const unsigned first = static_cast<unsigned>(around_.random.below(60));
    return fields(3, first, around_.random.between(1U, 10U));
  }
  const unsigned at = echo_random_.between(0U, 30U);
  const auto count = [this](unsigned most) { return echo_random_.between(1U, most); };
  const auto value = static_cast<std::uint16_t>(0xC000U | at);
  switch (echo_random_.between(0U, 16U)) {
    case 0: return fields(1, kFirstRunOfCoils + at, count(100));
    case 1: return fields(2, at, count(100));
    case 2: return fields(4, at, count(20));
    case 3: return fields(5, kFirstRunOfCoils + at, at % 2 == 0 ? kOn : 0);
    case 4: return fields(6, at, value);
    case 5: return coils_pdu(kFirstRunOfCoils + at, {value});
    case 6: return multiple_pdu(at, std::vector<std::uint16_t>(count(4), value));
    case 7: return {0x16, 0, low(at), 0xFF, 0xFF, high(value), low(value)};
    case 8: {
      PduBytes pdu = fields(0x17, at, count(8));
      append_word(pdu, at);
      append_word(pdu, 1);
      append_words(pdu, {value});
      return pdu;
    }
    case 9: return {0x07};
    case 10: return {0x0B};
    case 11: return {0x0C};
    case 12: return {0x11};
    case 13: return {0x14, 7, 6, 0, 4, 0, low(at), 0, low(count(8))};
    case 14: return {0x18, 0, low(at)};
    case 15: return {0x2B, 0x0E, 0x01, 0x00};
    default: return fields(8, 0, value);
  }
}

}  // namespace mbgate::soak
