// SPDX-License-Identifier: Apache-2.0
#include "soak/misfits.hpp"

#include "soak/pdus.hpp"

namespace mbgate::soak {
namespace {

constexpr std::uint8_t kFar = 0x40;      // in the high byte of an address: nobody asks for it
constexpr std::uint8_t kStrange = 0x80;  // in the high byte of a value: nobody writes it

bool is_read(std::uint8_t function) { return (function >= 1 && function <= 4) || function == 0x17; }

bool is_bits(std::uint8_t function) { return function <= 2; }

}  // namespace

bool make_misfit(std::vector<std::uint8_t>& pdu, const FaultRates& rates, Random& random,
                 const Happens& happens) {
  const std::uint8_t function = pdu[0];
  const bool repeats =
      function == 5 || function == 6 || function == 0x0F || function == 0x10 || function == 0x16;
  if (repeats && happens(rates.wrong_echo, "wrong_echo")) {
    constexpr std::size_t kAddress = 1;
    constexpr std::size_t kValue = 3;
    if (function == 5) {
      pdu[kValue] ^= 0xFFU;
    } else if (random.chance(500)) {
      pdu[kAddress] ^= kFar;
    } else {
      pdu[kValue] ^= kStrange;
    }
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
