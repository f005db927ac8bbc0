// SPDX-License-Identifier: Apache-2.0
// What begins at one of the last addresses of a table and ends behind them: nobody gets it, whoever
// it is for and whatever windows there are.
#include "soak/asking.hpp"
#include "soak/pdus.hpp"

namespace mbgate::soak {

Asked Asking::beyond_last(const Door& door) {
  constexpr std::uint8_t kBoth = 0x17;
  Asked asked = begin(door, Kind::read);
  asked.refused = 2;
  const unsigned left = ends_.between(1U, 4U);  // addresses from the first on
  const unsigned first = kAddresses - left;
  const unsigned count = left + ends_.between(1U, 4U);
  const unsigned kind = ends_.between(0U, 9U);
  if (kind < 2) {
    asked.pdu = fields(ends_.between(1U, 4U), first, count);
    return asked;
  }
  if (kind == 2) {
    asked.pdu = coils_pdu(first, {0});
  } else if (kind < 5) {
    asked.pdu = multiple_pdu(first, Words(count, 1));
  } else {  // either half, or both
    const bool reads_beyond = kind > 7;
    const bool writes_beyond = kind < 9;
    const unsigned writes = writes_beyond ? count : 1;
    asked.pdu = fields(kBoth, reads_beyond ? first : door.holding_at, reads_beyond ? count : 1);
    append_word(asked.pdu, writes_beyond ? first : door.holding_at);
    append_word(asked.pdu, writes);
    append_words(asked.pdu, Words(writes, 1));
  }
  if (door.read_only || may_only_read_) {
    asked.refused = 1;
  }
  return asked;
}

}  // namespace mbgate::soak
