// SPDX-License-Identifier: Apache-2.0
// Writes to registers, and what becomes of them: values stay whole, limits and groups are kept, the
// function is the one that the drive's maker prefers.
#include <algorithm>

#include "soak/asking.hpp"
#include "soak/pdus.hpp"

namespace mbgate::soak {
namespace {

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

bool cuts_motion(unsigned first, unsigned end) {
  const auto cuts = [](unsigned border) {
    return cuts_value(border) && is_motion(Table::holding_registers, border);
  };
  return cuts(first) || cuts(end);
}

bool touches_value(unsigned first, unsigned end) {
  for (unsigned at = first; at < end; ++at) {
    if (is_in_value(Table::holding_registers, at)) {
      return true;
    }
  }
  return false;
}

}  // namespace

Asked Asking::write(const Door& door) {
  Asked asked = begin(door, Kind::write);
  const unsigned kind = random_.between(0U, 29U);
  if (kind < 7) {
    const unsigned address = random_.between(0U, kLiveFrom - 1U);
    single(asked, address, next_value(asked, address));
  } else if (kind < 9) {
    const unsigned address = kSlowFrom + random_.between(0U, 3U);
    single(asked, address, next_value(asked, address));
  } else if (kind < 10) {
    asked.silent = true;
    single(asked, kSilentRegister,
           static_cast<std::uint16_t>(0x7000U | (next_value(asked, kSilentRegister) & 0xFFFU)));
  } else if (kind < 14) {
    const unsigned count = random_.between(1U, 10U);
    multiple(asked, random_.between(0U, kLiveFrom - count), count);
  } else if (kind < 17) {
    const unsigned pairs = random_.between(1U, 3U);
    multiple(asked, kPairsFrom + 2 * random_.between(0U, 20U - pairs), 2 * pairs);
  } else if (kind < 21) {
    write_somewhere(asked);
  } else if (kind < 23) {
    mask(asked);
  } else if (kind < 25) {
    read_and_write(asked);
  } else if (kind < 26) {
    opcode(asked);
  } else if (kind < 27) {
    coil(asked);
  } else if (kind < 28) {
    coils(asked);
  } else if (kind < 29) {
    own_function(asked);
  } else {
    random_.chance(500) ? file_record(asked) : diagnostics(asked);
  }
  check_functions(asked);
  refuse_if_read_only(asked);
  return asked;
}

// Whole values or parts of them, groups, what is only written, what starts motion, and how the
// drive communicates.
void Asking::write_somewhere(Asked& asked) {
  const unsigned from = random_.one_of<unsigned>(
      {kPairsFrom - 2U, kQuadsFrom, kQuadsFrom, kGroupsFrom, kGroupsFrom, kMotionFrom});
  const unsigned end = from < kPairsEnd ? kPairsEnd : kCommunicationRegister + 1U;
  const unsigned count = random_.between(1U, 8U);
  unsigned first = from + random_.between(0U, 8U);
  first = std::max(std::min(first, end - count), from < kPairsEnd ? kPairsFrom + 0U : from);
  if (count == 1 && random_.chance(500)) {
    // Of a value, the register that it will have on the wire is what must be unique.
    const bool moved = asked.door->swapped && is_in_value(Table::holding_registers, first);
    single(asked, first, next_value(asked, moved ? partner_of(first) : first));
  } else {
    multiple(asked, first, std::min(count, end - first));
  }
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

void Asking::multiple(Asked& asked, unsigned first, unsigned count) {
  Words words;
  for (unsigned at = 0; at < count; ++at) {
    words.push_back(next_value(asked, first + at));
  }
  plan_write(asked, first, words);
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
  if (cuts_motion(first, end) || (door.names_order && cuts_any(first, end))) {
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

// A run of 06; a whole value goes by one 16.
void Asking::add_singles(Asked& asked, unsigned first, const Words& words) const {
  const auto end = static_cast<unsigned>(first + words.size());
  for (unsigned at = first; at < end;) {
    const bool starts =
        is_in_value(Table::holding_registers, at) && value_begin(at) == at && value_end(at) <= end;
    const bool whole =
        starts && (is_motion(Table::holding_registers, at) || !device_of(asked).split_values);
    const unsigned stop = whole ? value_end(at) : at + 1;
    add_piece(asked, whole ? multiple_pdu(
                                 at, {words.begin() + (at - first), words.begin() + (stop - first)})
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

// 22: half of a value goes to its partner's address where the words are exchanged.
void Asking::mask(Asked& asked) {
  const Door& door = *asked.door;
  const unsigned address =
      random_.chance(500)   ? random_.between<unsigned>(kPairsFrom, kPairsEnd - 1)
      : random_.chance(200) ? random_.between<unsigned>(kQuadsFrom, kCommunicationRegister)
                            : random_.between(0U, kLiveFrom - 1U);
  const bool moved = door.swapped && is_in_value(Table::holding_registers, address);
  const unsigned place = moved ? partner_of(address) : address;
  const std::uint16_t set = next_value(asked, place);
  const auto keep = random_.one_of<std::uint16_t>({0x0000, 0xFF00, 0x00F0, 0xFFFF});
  const auto pdu = [&](unsigned at) {
    PduBytes bytes = fields(0x16, at, keep);
    append_word(bytes, set);
    return bytes;
  };
  asked.pdu = pdu(address + door.holding_at);
  if (door.routed && address == kCommunicationRegister && !device_of(asked).allow_reconfigure) {
    asked.refused = 1;
  } else if (door.routed && is_motion(Table::holding_registers, address)) {
    asked.refused = 3;
  } else {
    ask_for_order(asked, address, 1);
    add_piece(asked, pdu(place));
  }
}

// 23 cannot be split; what it shows is what the device held when it carried it out.
void Asking::read_and_write(Asked& asked) {
  const Door& door = *asked.door;
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
  if (cuts_motion(to, to + writes) || (door.names_order && cuts_any(to, to + writes)) ||
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

// An opcode with a position in the two registers behind it, whose order nobody states. Alone it is
// asked for only where it is refused: no two that are open are alike.
void Asking::opcode(Asked& asked) {
  const Door& door = *asked.door;
  const drive::Device& device = device_of(asked);
  const auto& order = device.opcode_order;
  const bool is_other =
      door.names_order && order && *order != *plan_.settings.routes[*door.route].word_order;
  const bool is_uncertain = !order && door.swapped;
  Words words{kPositionOpcode, next_value(asked, kOpcodeRegister + 1U),
              next_value(asked, kOpcodeRegister + 2U)};
  const bool is_alone = (is_other || is_uncertain) && random_.chance(300);
  if (device.write_function == 6) {
    words[0] = next_value(asked, kOpcodeRegister);  // none: it would be written by itself
  } else if (is_alone) {
    words.resize(1);
  }
  plan_write(asked, kOpcodeRegister, words);
  if (words[0] != kPositionOpcode || asked.refused) {
    return;
  }
  if (is_alone || is_uncertain) {
    asked.refused = 3;
    asked.pieces.clear();
  } else if (is_other) {
    asked.pdu = multiple_pdu(kOpcodeRegister + door.holding_at, {words[0], words[2], words[1]});
  }
}

}  // namespace mbgate::soak
