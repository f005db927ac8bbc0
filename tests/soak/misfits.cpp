// SPDX-License-Identifier: Apache-2.0
#include "soak/misfits.hpp"

#include "soak/pdus.hpp"
#include "soak/registers.hpp"

namespace mbgate::soak {
namespace {

constexpr std::uint8_t kStrange = 0x80;  // in any byte of a value or quantity: nobody writes it
constexpr std::uint8_t kFar = 0x40;      // in the high byte of an address: nobody asks for it

bool is_read(std::uint8_t function) { return (function >= 1 && function <= 4) || function == 0x17; }

bool is_bits(std::uint8_t function) { return function <= 2; }

// The first byte of those that must be what they were in the request, or what the specification
// says; behind it there are none, or all are. 0: nobody compares any.
std::size_t first_fixed(std::uint8_t function) {
  switch (function) {
    case 0x05:
    case 0x06:
    case 0x08:
    case 0x0F:
    case 0x10:
    case 0x16: return 1;
    case 0x15: return 2;  // its length stands before
    case 0x14: return 2;  // of the group its length, and the reference type
    case 0x18: return 3;  // how many registers it holds
    default: return 0;
  }
}

std::size_t end_of_fixed(const std::vector<std::uint8_t>& pdu) {
  // Of 08 only what is asked for by 0 comes back as it was: other answers hold counters.
  const bool has_data = pdu[0] == 0x08 && (pdu[1] != 0 || pdu[2] != 0);
  return pdu[0] == 0x14 ? 4 : pdu[0] == 0x18 ? 5 : has_data ? 3 : pdu.size();
}

// One byte becomes another, so that it is the answer to nobody's request.
void change(std::vector<std::uint8_t>& pdu, std::size_t at) {
  constexpr std::size_t kAddress = 1;
  constexpr unsigned kNobodys = 0x100 - kRegisters;  // low bytes that no register's address has
  const std::uint8_t function = pdu[0];
  const bool names_register = function == 0x06 || function == 0x10 || function == 0x16;
  if (function == 0x05 && at == 3) {
    pdu[at] ^= 0xFFU;
  } else if (names_register && at == kAddress + 1) {
    pdu[at] = low(kRegisters + pdu[at] % kNobodys);
  } else {
    pdu[at] ^= at == kAddress ? kFar : kStrange;
  }
}

}  // namespace

bool make_misfit(std::vector<std::uint8_t>& pdu, const FaultRates& rates, Random& random,
                 const Happens& happens) {
  const std::uint8_t function = pdu[0];
  const std::size_t fixed = first_fixed(function);
  const bool is_seldom = function == 0x08 || function == 0x14 || function == 0x15 ||
                         function == 0x16 || function == 0x18;
  if (fixed > 0 && happens(rates.wrong_echo * (is_seldom ? 6 : 1), "wrong_echo")) {
    change(pdu, random.between(fixed, end_of_fixed(pdu) - 1));
    return true;
  }
  const std::size_t less = is_bits(function) ? 1 : 2;
  if (is_read(function) && pdu.size() > 2 + less && happens(rates.too_short, "too_short")) {
    pdu.erase(pdu.end() - static_cast<std::ptrdiff_t>(less), pdu.end());
    pdu[1] = low(static_cast<unsigned>(pdu.size() - 2));
    return true;
  }
  return false;
}

}  // namespace mbgate::soak
