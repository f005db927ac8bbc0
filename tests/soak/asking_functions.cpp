// SPDX-License-Identifier: Apache-2.0
// What is asked more seldom: coils, masks, reads and writes in one, halves of values, a function of
// the maker's own, and who the device is.
#include <algorithm>

#include "soak/asking.hpp"
#include "soak/pdus.hpp"

namespace mbgate::soak {
namespace {

constexpr unsigned kWordOfCoils = 16;

/// Where windows show holding registers and input registers only, a coil lies in none.
bool is_outside(Asked& asked) {
  if (asked.door->windowed) {
    asked.refused = 2;
  }
  return asked.door->windowed;
}

std::uint16_t scattered(std::uint16_t counter) {
  constexpr unsigned kOdd = 40503;  // so that no two are alike
  return static_cast<std::uint16_t>(counter * kOdd);
}

PduBytes coils_pdu(unsigned first, const std::vector<std::uint16_t>& words) {
  PduBytes pdu = fields(0x0F, first, static_cast<unsigned>(words.size()) * kWordOfCoils);
  pdu.push_back(low(static_cast<unsigned>(words.size() * 2)));
  for (const std::uint16_t word : words) {
    pdu.push_back(low(word));  // the first coil is the lowest bit of the first byte
    pdu.push_back(high(word));
  }
  return pdu;
}

void exchange_pairs(std::vector<std::uint16_t>& words, unsigned first) {
  for (unsigned at = 0; at + 1 < words.size(); ++at) {
    if (is_in_pair(Table::holding_registers, first + at) && pair_of(first + at) == first + at) {
      std::swap(words[at], words[at + 1]);
      ++at;
    }
  }
}

bool is_inside_pair(unsigned border) {
  return is_in_pair(Table::holding_registers, border) && pair_of(border) != border;
}

}  // namespace

Asked Asking::identity(const Door& door) {
  Asked asked = begin(door, Kind::read);
  asked.pdu = random_.chance(500) ? PduBytes{0x11} : PduBytes{0x2B, 0x0E, 0x01, 0x00};
  if (door.windowed) {
    asked.refused = 1;  // no window can rewrite it
    return asked;
  }
  asked.identity = true;
  add_piece(asked, asked.pdu);
  return asked;
}

// Mostly those that were written not long ago.
Asked Asking::read_bits(const Door& door) {
  Asked asked = begin(door, Kind::read);
  const Table table =
      random_.one_of({Table::coils, Table::coils, Table::coils, Table::discrete_inputs});
  const unsigned count = random_.between(1U, 100U);
  const unsigned turn = counters_[*door.device][kCoil];
  const unsigned near =
      random_.one_of<unsigned>({turn % kFirstRunOfCoils, kFirstRunOfCoils, kCoils - count,
                                static_cast<unsigned>(random_.below(kCoils))});
  const unsigned first = std::min(near - std::min(near, count / 2), kCoils - count);
  plan_read(asked, table, first, count);
  if (is_outside(asked)) {
    asked.check.reset();
    asked.pieces.clear();
  }
  return asked;
}

void Asking::rare_write(Asked& asked) {
  switch (random_.between(0U, 6U)) {
    case 0: coil(asked); return;
    case 1: coils(asked); return;
    case 2:
    case 3: mask(asked); return;
    case 4: half_values(asked); return;
    case 5: read_and_write(asked); return;
    default: own_function(asked); return;
  }
}

// Each coil in its turn, on the first round and off the next: no two that are open are alike.
void Asking::coil(Asked& asked) {
  const unsigned turn = next_value(asked, kCoil);
  const unsigned address = turn % kFirstRunOfCoils;
  asked.pdu = fields(5, address, (turn / kFirstRunOfCoils) % 2 == 0 ? 0xFF00 : 0);
  if (!is_outside(asked)) {
    add_piece(asked, asked.pdu);
  }
}

void Asking::coils(Asked& asked) {
  std::vector<std::uint16_t> words(random_.between(1U, 8U));
  for (std::uint16_t& word : words) {
    word = scattered(next_value(asked, kRunOfCoils));
  }
  const auto count = static_cast<unsigned>(words.size()) * kWordOfCoils;
  const unsigned first = random_.between<unsigned>(kFirstRunOfCoils, kCoils - count);
  asked.pdu = coils_pdu(first, words);
  if (is_outside(asked)) {
    return;
  }
  const drive::Device& device = device_of(asked);
  const unsigned limit = asked.door->routed ? device.profile.limits.write_coils : 1968U;
  if (count > limit && !device.split_writes) {
    asked.refused = 3;
    return;
  }
  const std::size_t most = limit / kWordOfCoils;
  for (std::size_t at = 0; at < words.size(); at += most) {
    const std::size_t end = std::min(words.size(), at + most);
    add_piece(asked, coils_pdu(first + static_cast<unsigned>(at) * kWordOfCoils,
                               {words.begin() + static_cast<std::ptrdiff_t>(at),
                                words.begin() + static_cast<std::ptrdiff_t>(end)}));
  }
}

// 22: half of a value goes to its partner's address where the words are exchanged.
void Asking::mask(Asked& asked) {
  const Door& door = *asked.door;
  const unsigned address = random_.chance(500)
                               ? random_.between<unsigned>(kPairsFrom, kPairsEnd - 1)
                               : random_.between(0U, kLiveFrom - 1U);
  const bool moved = door.swapped && is_in_pair(Table::holding_registers, address);
  const unsigned place = moved ? partner_of(address) : address;
  const std::uint16_t set = next_value(asked, place);
  const auto keep = random_.one_of<std::uint16_t>({0x0000, 0xFF00, 0x00F0, 0xFFFF});
  const auto pdu = [&](unsigned at) {
    PduBytes bytes = fields(0x16, at, keep);
    append_word(bytes, set);
    return bytes;
  };
  asked.pdu = pdu(address + (door.windowed ? kHoldingWindow : 0U));
  add_piece(asked, pdu(place));
}

// 16 anywhere over values, also a single register. Where the route names an order, none may be cut.
void Asking::half_values(Asked& asked) {
  const Door& door = *asked.door;
  const unsigned count = random_.between(1U, 6U);
  const unsigned first = random_.between<unsigned>(kPairsFrom - 2U, kPairsEnd - count);
  const bool cuts = is_inside_pair(first) || is_inside_pair(first + count);
  if (first < kPairsFrom || !cuts) {
    multiple(asked, kPairsFrom, 2);
    return;
  }
  std::vector<std::uint16_t> words;
  for (unsigned at = 0; at < count; ++at) {
    words.push_back(next_value(asked, first + at));
  }
  asked.pdu = multiple_pdu(first + (door.windowed ? kHoldingWindow : 0U), words);
  const drive::Device& device = device_of(asked);
  const unsigned limit = door.routed ? device.profile.limits.write_registers : 123U;
  if (door.names_order || (count > limit && !device.split_writes)) {
    asked.refused = 3;
    return;
  }
  for (unsigned at = 0; at < count;) {
    unsigned end = std::min(count, at + limit);
    if (end < count && is_inside_pair(first + end)) {
      --end;
    }
    add_piece(asked, multiple_pdu(first + at, {words.begin() + at, words.begin() + end}));
    at = end;
  }
}

// 23 cannot be split; what it shows is what the device held when it carried it out.
void Asking::read_and_write(Asked& asked) {
  const Door& door = *asked.door;
  const bool values = random_.chance(500);
  const unsigned writes = random_.between(1U, 8U);
  const unsigned to = values ? random_.between<unsigned>(kPairsFrom, kPairsEnd - writes)
                             : random_.between<unsigned>(0U, kLiveFrom - writes);
  const unsigned reads = random_.between(1U, 16U);
  const unsigned from = std::min(to - std::min(to, random_.between(0U, 8U)), kRegisters - reads);
  std::vector<std::uint16_t> words;
  for (unsigned at = 0; at < writes; ++at) {
    words.push_back(next_value(asked, to + at));
  }
  const auto pdu = [&](unsigned first, unsigned count, unsigned base,
                       const std::vector<std::uint16_t>& data) {
    PduBytes bytes = fields(0x17, first + base, count);
    append_word(bytes, to + base);
    append_word(bytes, writes);
    append_words(bytes, data);
    return bytes;
  };
  std::vector<std::uint16_t> shown = words;
  if (door.swapped) {
    exchange_pairs(shown, to);
  }
  asked.pdu = pdu(from, reads, door.windowed ? kHoldingWindow : 0U, shown);
  const unsigned first = door.swapped && is_inside_pair(from) ? from - 1 : from;
  const unsigned end =
      door.swapped && is_inside_pair(from + reads) ? from + reads + 1 : from + reads;
  const drive::Limits& limits = device_of(asked).profile.limits;
  const bool cuts = is_inside_pair(to) || is_inside_pair(to + writes);
  if ((door.names_order && cuts) ||
      (door.routed && (writes > limits.write_registers ||
                       end - first > limits.read_from(Table::holding_registers)))) {
    asked.refused = 3;
    return;
  }
  asked.check = ReadCheck{Table::holding_registers, static_cast<std::uint16_t>(from),
                          static_cast<std::uint16_t>(reads), door.swapped};
  add_piece(asked, pdu(first, end - first, 0, words));
}

// The device repeats it or does not know it; how long the answer is nobody knows before.
void Asking::own_function(Asked& asked) {
  const std::uint16_t turn = next_value(asked, kOwnCommand);
  const std::uint8_t command =
      random_.chance(800) ? kKnownCommand : static_cast<std::uint8_t>(kKnownCommand + 1);
  asked.pdu = {kOwnFunction, command, high(turn), low(turn)};
  for (unsigned count = random_.between(0U, 40U); count > 0; --count) {
    asked.pdu.push_back(static_cast<std::uint8_t>(random_.below(256)));
  }
  if (asked.door->windowed) {
    asked.refused = 1;
  } else {
    add_piece(asked, asked.pdu);
  }
}

}  // namespace mbgate::soak
