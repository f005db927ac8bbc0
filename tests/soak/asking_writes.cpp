// SPDX-License-Identifier: Apache-2.0
// What is written to registers: one or several, whole values or parts of them, masks and opcodes.
#include <algorithm>

#include "soak/asking.hpp"
#include "soak/pdus.hpp"

namespace mbgate::soak {
namespace {

constexpr unsigned kRare = 150;  // permille of writes

}  // namespace

Asked Asking::write(const Door& door) {
  Asked asked = begin(door, Kind::write);
  const unsigned kind = random_.between(0U, 29U);
  if (rare_.chance(kRare)) {
    rare(asked);
  } else if (kind < 7) {
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

// By 16, whose answer does not say what was written.
Asked Asking::alike_write(const Door& door) {
  Asked asked = begin(door, Kind::write);
  multiple(asked, 2 * near_.below(2U), 2);
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

void Asking::multiple(Asked& asked, unsigned first, unsigned count) {
  Words words;
  for (unsigned at = 0; at < count; ++at) {
    words.push_back(next_value(asked, first + at));
  }
  plan_write(asked, first, words);
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
