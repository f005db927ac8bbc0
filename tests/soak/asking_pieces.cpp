// SPDX-License-Identifier: Apache-2.0
// What becomes of writes to registers: values stay whole, limits and groups are kept, the function
// is the one that the drive's maker prefers.
#include <algorithm>

#include "soak/asking.hpp"
#include "soak/pdus.hpp"

namespace mbgate::soak {
namespace {

bool cuts_motion(unsigned first, unsigned end) {
  const auto cuts = [](unsigned border) {
    return cuts_value(border) && is_motion(Table::holding_registers, border);
  };
  return cuts(first) || cuts(end);
}

}  // namespace

// In the other word order, but for values that are not whole.
Words exchanged(Words words, unsigned first) {
  for (unsigned at = 0; at < words.size();) {
    const unsigned address = first + at;
    const bool whole = is_in_value(Table::holding_registers, address) &&
                       value_begin(address) == address &&
                       value_end(address) <= first + words.size();
    const unsigned size = whole ? value_end(address) - address : 1;
    std::reverse(words.begin() + at, words.begin() + at + size);
    at += size;
  }
  return words;
}

bool cuts_any(unsigned first, unsigned end) { return cuts_value(first) || cuts_value(end); }

bool touches_value(unsigned first, unsigned end) {
  for (unsigned at = first; at < end; ++at) {
    if (is_in_value(Table::holding_registers, at)) {
      return true;
    }
  }
  return false;
}

void Asking::single(Asked& asked, unsigned address, std::uint16_t value) const {
  const Door& door = *asked.door;
  asked.pdu = fields(6, address + door.holding_at, value);
  if (!door.routed) {
    add_piece(asked, fields(6, address, value));
    return;
  }
  const drive::Device& device = device_of(asked);
  if (address == kCommunicationRegister && !device.allow_reconfigure) {
    asked.refused = 1;
    return;
  }
  if (is_motion(Table::holding_registers, address)) {
    asked.refused = 3;
    return;
  }
  ask_for_order(asked, address, 1);
  const bool moved = door.swapped && is_in_value(Table::holding_registers, address);
  const unsigned place = moved ? partner_of(address) : address;
  add_piece(asked,
            device.write_function == 16 ? multiple_pdu(place, {value}) : fields(6, place, value));
}

// 16, with the words as the drive gets them.
void Asking::plan_write(Asked& asked, unsigned first, const Words& words) const {
  const Door& door = *asked.door;
  const auto end = static_cast<unsigned>(first + words.size());
  asked.pdu = multiple_pdu(first + door.holding_at, door.swapped ? exchanged(words, first) : words);
  if (!door.routed) {
    add_piece(asked, multiple_pdu(first, words));
    return;
  }
  const drive::Device& device = device_of(asked);
  if (first <= kCommunicationRegister && end > kCommunicationRegister &&
      !device.allow_reconfigure) {
    asked.refused = 1;
    return;
  }
  if (cuts_motion(first, end) || cuts_any(first, end)) {
    asked.refused = 3;
    return;
  }
  ask_for_order(asked, first, end - first);
  if (device.write_function == 6) {
    add_singles(asked, first, words);
  } else {
    const bool is_opcode = first <= kOpcodeRegister && end > kOpcodeRegister;
    add_writes(asked, first, words, is_opcode || !device.split_writes);
  }
}

void Asking::add_writes(Asked& asked, unsigned first, const Words& words, bool together) const {
  const auto end = static_cast<unsigned>(first + words.size());
  const unsigned limit = device_of(asked).profile.limits.write_registers;
  if (together && end_of_piece(Table::holding_registers, first, end, limit) < end) {
    asked.refused = 3;
    asked.pieces.clear();
    return;
  }
  for (unsigned at = first; at < end;) {
    const unsigned stop = end_of_piece(Table::holding_registers, at, end, limit);
    add_piece(asked,
              multiple_pdu(at, {words.begin() + (at - first), words.begin() + (stop - first)}));
    at = stop;
  }
}

// A run of 06; as much of a value as is written goes by one 16.
void Asking::add_singles(Asked& asked, unsigned first, const Words& words) const {
  const auto end = static_cast<unsigned>(first + words.size());
  for (unsigned at = first; at < end;) {
    const bool stays_together =
        is_in_value(Table::holding_registers, at) &&
        (is_motion(Table::holding_registers, at) || !device_of(asked).split_values);
    const unsigned stop = stays_together ? std::min(value_end(at), end) : at + 1;
    add_piece(asked, stop - at > 1 ? multiple_pdu(at, {words.begin() + (at - first),
                                                       words.begin() + (stop - first)})
                                   : fields(6, at, words[at - first]));
    at = stop;
  }
}

// Before values are written the drive is asked which order it has. If it has another one the client
// gets 04, and nothing is written.
void Asking::ask_for_order(Asked& asked, unsigned first, unsigned count) const {
  const drive::Device& device = device_of(asked);
  if (device.verify_word_order && asked.door->names_order && touches_value(first, first + count)) {
    add_piece(asked, fields(3, kOrderRegister, 1));
    asked.pieces.back().asks_order = true;
    asked.other_order = plan_.own_orders[*asked.door->device] != *device.word_order;
  }
}

// 23 cannot be split; what it shows is what the device held when it carried it out.
void Asking::read_and_write(Asked& asked) {
  const unsigned writes = random_.between(1U, 8U);
  const unsigned to = random_.chance(400) ? random_.between<unsigned>(0U, kLiveFrom - writes)
                      : random_.chance(700)
                          ? random_.between<unsigned>(kPairsFrom, kPairsEnd - writes)
                          : random_.between<unsigned>(kQuadsFrom, kCommunicationRegister - writes);
  const unsigned reads = random_.between(1U, 16U);
  const unsigned from = std::min(to - std::min(to, random_.between(0U, 8U)), kRegisters - reads);
  Words words;
  for (unsigned at = 0; at < writes; ++at) {
    words.push_back(next_value(asked, to + at));
  }
  plan_read_and_write(asked, to, words, from, reads);
}

void Asking::plan_read_and_write(Asked& asked, unsigned to, const Words& words, unsigned from,
                                 unsigned reads) const {
  const Door& door = *asked.door;
  const auto writes = static_cast<unsigned>(words.size());
  const auto pdu = [&](unsigned first, unsigned count, unsigned base, const Words& data) {
    PduBytes bytes = fields(0x17, first + base, count);
    append_word(bytes, to + base);
    append_word(bytes, writes);
    append_words(bytes, data);
    return bytes;
  };
  asked.pdu = pdu(from, reads, door.holding_at, door.swapped ? exchanged(words, to) : words);
  asked.check = ReadCheck{Table::holding_registers, static_cast<std::uint16_t>(from),
                          static_cast<std::uint16_t>(reads), door.swapped};
  if (!door.routed) {
    add_piece(asked, pdu(from, reads, 0, words));
    return;
  }
  const unsigned first = door.swapped && cuts_value(from) ? value_begin(from) : from;
  const unsigned last = from + reads;
  const unsigned end = door.swapped && cuts_value(last) ? value_end(last) : last;
  const drive::Limits& limits = device_of(asked).profile.limits;
  const auto is_one = [](unsigned begin, unsigned behind, unsigned limit) {
    return end_of_piece(Table::holding_registers, begin, behind, limit) == behind;
  };
  if (cuts_motion(to, to + writes) || cuts_any(to, to + writes) ||
      !is_one(to, to + writes, limits.write_registers) ||
      !is_one(first, end, limits.read_from(Table::holding_registers))) {
    asked.refused = 3;
    return;
  }
  ask_for_order(asked, to, writes);
  if (asked.pieces.empty()) {
    ask_for_order(asked, from, reads);
  }
  add_piece(asked, pdu(first, end - first, 0, words));
}

}  // namespace mbgate::soak
