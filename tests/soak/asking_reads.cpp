// SPDX-License-Identifier: Apache-2.0
// What is read: registers and bits of every table, and who the device is.
#include <algorithm>

#include "soak/asking.hpp"
#include "soak/pdus.hpp"

namespace mbgate::soak {
namespace {

unsigned read_function(Table table) {
  switch (table) {
    case Table::coils: return 1;
    case Table::discrete_inputs: return 2;
    case Table::holding_registers: return 3;
    case Table::input_registers: return 4;
  }
  return 0;
}

unsigned shown_at(const Door& door, Table table) {
  switch (table) {
    case Table::coils: return door.coils_at;
    case Table::discrete_inputs: return 0;
    case Table::holding_registers: return door.holding_at;
    case Table::input_registers: return door.input_at;
  }
  return 0;
}

}  // namespace

unsigned end_of_piece(Table table, unsigned first, unsigned end, unsigned limit) {
  unsigned stop = std::min(end, first + limit);
  if (table != Table::holding_registers) {
    return stop;
  }
  constexpr unsigned kGroup = 4;
  if (first < kGroupsFrom) {
    stop = std::min<unsigned>(stop, kGroupsFrom);
  } else if (first < kGroupsEnd) {
    stop = std::min(stop, kGroupsFrom + ((first - kGroupsFrom) / kGroup + 1) * kGroup);
  }
  const bool cuts = stop < end && cuts_value(stop) && value_begin(stop) > first;
  return cuts ? value_begin(stop) : stop;
}

Asked Asking::read(const Door& door, bool popular) {
  Asked asked = begin(door, Kind::read);
  if (popular) {
    plan_read(asked, Table::holding_registers, kLiveFrom, 4);
    return asked;
  }
  const unsigned kind = random_.between(0U, 19U);
  if (kind <= 1) {
    asked = identity(door);
  } else if (kind <= 4) {
    asked = read_bits(door);
  } else if (kind <= 7) {
    plan_read(asked, Table::input_registers, random_.between(0U, 70U), random_.between(1U, 30U));
  } else {
    const unsigned count =
        random_.chance(100) ? random_.between(30U, 120U) : random_.between(1U, 12U);
    plan_read(asked, Table::holding_registers, random_.between(0U, kRegisters - count), count);
  }
  check_functions(asked);
  return asked;
}

// Beside, or over, what others read.
Asked Asking::near_read(const Door& door) {
  constexpr unsigned kPlaces = 8;
  Asked asked = begin(door, Kind::read);
  plan_read(asked, Table::holding_registers, kLiveFrom + near_.below(kPlaces),
            near_.between(1U, 4U));
  return asked;
}

// By its answer nobody can tell it from others.
Asked Asking::alike_read(const Door& door) {
  constexpr unsigned kPlaces = 12;
  Asked asked = begin(door, Kind::read);
  plan_read(asked, Table::holding_registers, kLiveFrom + 2 * near_.below(kPlaces), 2);
  return asked;
}

// Values are widened where their words are exchanged. A drive that shows its holding registers as
// input registers shows their values there too.
void Asking::plan_read(Asked& asked, Table table, unsigned first, unsigned count) const {
  const Door& door = *asked.door;
  const drive::Profile& profile = device_of(asked).profile;
  const bool is_input = table == Table::input_registers;
  const Table known = is_input && profile.input_as_holding ? Table::holding_registers : table;
  asked.check = ReadCheck{known, static_cast<std::uint16_t>(first),
                          static_cast<std::uint16_t>(count), door.swapped};
  asked.pdu = fields(door.windowed && is_input ? 3 : read_function(table),
                     first + shown_at(door, table), count);
  unsigned end = first + count;
  if (!door.routed) {
    add_piece(asked, fields(read_function(table), first, count));
    return;
  }
  if (door.swapped && is_in_value(known, first)) {
    first = value_begin(first);
  }
  if (door.swapped && is_in_value(known, end - 1)) {
    end = value_end(end - 1);
  }
  const Table sent = end - first > profile.limits.read_from(table) ? known : table;
  while (first < end) {
    const unsigned stop = end_of_piece(known, first, end, profile.limits.read_from(sent));
    add_piece(asked, fields(read_function(sent), first, stop - first));
    first = stop;
  }
}

Asked Asking::identity(const Door& door) {
  Asked asked = begin(door, Kind::read);
  const unsigned from = random_.between(0U, 50U);
  const unsigned count = random_.between(1U, 8U);
  switch (random_.between(0U, 6U)) {
    case 0: asked.pdu = {0x07}; break;
    case 1: asked.pdu = {0x0B}; break;
    case 2: asked.pdu = {0x0C}; break;
    case 3: asked.pdu = {0x14, 7, 6, 0, 4, 0, low(from), 0, low(count)}; break;
    case 4: asked.pdu = {0x18, high(from + door.holding_at), low(from + door.holding_at)}; break;
    case 5: asked.pdu = {0x11}; break;
    default: asked.pdu = {0x2B, 0x0E, 0x01, 0x00};
  }
  const bool has_address = asked.pdu[0] == 0x18;
  if (door.windowed && !has_address) {
    asked.refused = 1;  // no window can rewrite it
    return asked;
  }
  asked.identity = true;
  add_piece(asked, has_address ? PduBytes{0x18, 0, low(from)} : asked.pdu);
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
  if (door.windowed && (table == Table::discrete_inputs || !door.shows_coils)) {
    asked.refused = 2;
    asked.check.reset();
    asked.pieces.clear();
  }
  return asked;
}

}  // namespace mbgate::soak
