// SPDX-License-Identifier: Apache-2.0
#include "soak/asking.hpp"

#include <algorithm>

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

}  // namespace

Asking::Asking(const SoakPlan& plan, Random& random)
    : plan_(plan),
      random_(random),
      counters_(plan.settings.devices.size()),
      device_doors_(plan.settings.listeners.size()),
      broadcast_doors_(plan.settings.listeners.size()) {
  for (const Door& door : plan.doors) {
    (door.device ? device_doors_ : broadcast_doors_)[door.listener].push_back(&door);
  }
}

const Door* Asking::door_of(std::size_t listener, bool broadcast) {
  const auto& doors = (broadcast ? broadcast_doors_ : device_doors_)[listener];
  if (doors.empty()) {
    return nullptr;
  }
  const Door* picked = doors[random_.below(doors.size())];
  // What its unit leads to now.
  const auto in_force = std::ranges::find_if(
      doors, [&](const Door* door) { return door->unit == picked->unit && !door->absent; });
  return in_force == doors.end() ? picked : *in_force;
}

Asked Asking::make(const Manners& manners) {
  const Door& door = *door_of(manners.listener, false);
  if (door.absent) {
    return door.route ? for_nobody(door) : own_read(0, 4);
  }
  if (random_.chance(manners.malformed)) {
    return malformed(door);
  }
  if (random_.chance(manners.broadcasts)) {
    if (const Door* all = door_of(manners.listener, true); all != nullptr && !all->absent) {
      return broadcast(*all);
    }
  }
  if (random_.chance(manners.stops)) {
    return stop(door);
  }
  if (random_.chance(manners.writes)) {
    return write(door);
  }
  return read(door, random_.chance(manners.same_reads));
}

Asked Asking::fresh_read(const Door& door) {
  Asked asked = begin(door, Kind::read);
  plan_read(asked, Table::holding_registers, kLiveFrom, 4);
  return asked;
}

Asked Asking::for_nobody(const Door& door) {
  Asked asked = begin(door, Kind::read);
  asked.refused = 0x0A;
  asked.pdu = fields(random_.one_of({3U, 6U}), random_.between(0U, 10U), 1);
  return asked;
}

Asked Asking::own_read(std::uint16_t first, std::uint16_t count) {
  Asked asked;
  asked.kind = Kind::own;
  asked.unit = 255;
  asked.pdu = fields(4, first, count);
  return asked;
}

Asked Asking::read(const Door& door, bool popular) {
  Asked asked = begin(door, Kind::read);
  if (popular) {
    plan_read(asked, Table::holding_registers, kLiveFrom, 4);
    return asked;
  }
  const unsigned kind = random_.between(0U, 19U);
  if (kind == 0) {
    return identity(door);
  }
  if (kind <= 3) {
    return read_bits(door);
  }
  if (kind <= 6) {
    plan_read(asked, Table::input_registers, random_.between(0U, 70U), random_.between(1U, 30U));
  } else {
    const unsigned count =
        random_.chance(100) ? random_.between(30U, 120U) : random_.between(1U, 12U);
    plan_read(asked, Table::holding_registers, random_.between(0U, kRegisters - count), count);
  }
  return asked;
}

void Asking::plan_read(Asked& asked, Table table, unsigned first, unsigned count) const {
  const Door& door = *asked.door;
  asked.check = ReadCheck{table, static_cast<std::uint16_t>(first),
                          static_cast<std::uint16_t>(count), door.swapped};
  const bool window = door.windowed && table == Table::input_registers;
  unsigned shown = first;
  if (door.windowed) {
    shown += window ? kInputWindow : kHoldingWindow;
  }
  asked.pdu = fields(window ? 3 : read_function(table), shown, count);
  unsigned end = first + count;
  if (door.swapped && is_in_pair(table, first)) {
    first = pair_of(first);
  }
  if (door.swapped && is_in_pair(table, end - 1)) {
    end = pair_of(end - 1) + 2U;
  }
  const unsigned limit = door.routed ? device_of(asked).profile.limits.read_from(table) : 2000U;
  while (first < end) {
    unsigned stop = std::min(end, first + limit);
    if (door.routed && stop < end && is_in_pair(table, stop) && pair_of(stop) != stop) {
      --stop;
    }
    add_piece(asked, fields(read_function(table), first, stop - first));
    first = stop;
  }
}

void Asking::add_piece(Asked& asked, PduBytes pdu) const {
  asked.pieces.push_back(
      {asked.door->buses.front(), device_of(asked).address, std::move(pdu), 0, false, false});
}

std::uint16_t Asking::next_value(const Asked& asked, unsigned address) {
  return ++counters_[*asked.door->device].at(address);
}

Asked Asking::write(const Door& door) {
  Asked asked = begin(door, Kind::write);
  if (random_.chance(350)) {
    rare_write(asked);
    refuse_if_read_only(asked);
    return asked;
  }
  const unsigned kind = random_.between(0U, 19U);
  if (kind < 8) {
    const unsigned address = random_.between(0U, kLiveFrom - 1U);
    single(asked, address, next_value(asked, address));
  } else if (kind < 9) {
    const unsigned address = kSlowFrom + random_.between(0U, 3U);
    single(asked, address, next_value(asked, address));
  } else if (kind < 11) {
    // Of a value, the register that it will have on the wire is what must be unique.
    const unsigned address = random_.between<unsigned>(kPairsFrom, kPairsEnd - 1);
    single(asked, address, next_value(asked, door.swapped ? partner_of(address) : address));
  } else if (kind < 12) {
    asked.silent = true;
    single(asked, kSilentRegister,
           static_cast<std::uint16_t>(0x7000U | (next_value(asked, kSilentRegister) & 0xFFFU)));
  } else if (kind < 16) {
    const unsigned count = random_.between(1U, 10U);
    multiple(asked, random_.between(0U, kLiveFrom - count), count);
  } else {
    const unsigned pairs = random_.between(1U, 3U);
    multiple(asked, kPairsFrom + 2 * random_.between(0U, 20U - pairs), 2 * pairs);
  }
  refuse_if_read_only(asked);
  return asked;
}

void Asking::refuse_if_read_only(Asked& asked) {
  if (asked.door->read_only) {
    asked.refused = 1;
    asked.pieces.clear();
  }
}

void Asking::single(Asked& asked, unsigned address, std::uint16_t value) const {
  const Door& door = *asked.door;
  const bool moved = door.swapped && is_in_pair(Table::holding_registers, address);
  asked.pdu = fields(6, address + (door.windowed ? kHoldingWindow : 0U), value);
  add_piece(asked, fields(6, moved ? partner_of(address) : address, value));
}

void Asking::multiple(Asked& asked, unsigned first, unsigned count) {
  const Door& door = *asked.door;
  std::vector<std::uint16_t> device_words;
  for (unsigned at = 0; at < count; ++at) {
    device_words.push_back(next_value(asked, first + at));
  }
  std::vector<std::uint16_t> client_words = device_words;
  const bool pairs = is_in_pair(Table::holding_registers, first);
  if (door.swapped && pairs) {
    for (unsigned at = 0; at < count; at += 2) {
      std::swap(client_words[at], client_words[at + 1]);
    }
  }
  asked.pdu = multiple_pdu(first + (door.windowed ? kHoldingWindow : 0U), client_words);
  const drive::Device& device = device_of(asked);
  unsigned limit = door.routed ? device.profile.limits.write_registers : 123U;
  if (pairs) {
    limit &= ~1U;
  }
  if (count > limit && !device.split_writes) {
    asked.refused = 3;
    return;
  }
  for (unsigned at = 0; at < count; at += limit) {
    const unsigned end = std::min(count, at + limit);
    add_piece(asked,
              multiple_pdu(first + at, {device_words.begin() + at, device_words.begin() + end}));
  }
}

Asked Asking::stop(const Door& door) {
  if (door.read_only) {
    return read(door, false);
  }
  Asked asked = begin(door, Kind::stop);
  const bool same = random_.chance(300);
  single(asked, kStopRegister,
         static_cast<std::uint16_t>(0x5000U |
                                    (same ? 0xFFFU : next_value(asked, kStopRegister) % 0xFFEU)));
  return asked;
}

Asked Asking::broadcast(const Door& door) {
  Asked asked = begin(door, Kind::broadcast);
  asked.replies = door.replies;
  asked.stops_all = random_.chance(400);
  ++broadcasts_;
  asked.pdu = fields(6, kBroadcastRegister, broadcasts_);
  if (asked.stops_all) {
    // Of those that get no reply nobody could tell when each has ended.
    const bool same = door.replies && random_.chance(300);
    asked.pdu = fields(6, kStopRegister, 0x5000U | (same ? 0xFFFU : broadcasts_ % 0xFFEU));
  }
  for (const std::size_t bus : door.buses) {
    asked.pieces.push_back({bus, 0, asked.pdu, 0, false, false});
  }
  return asked;
}

Asked Asking::malformed(const Door& door) {
  Asked asked = begin(door, Kind::read);
  const unsigned address = door.windowed ? kHoldingWindow : 0U;
  asked.refused = 3;
  switch (random_.between(0U, 5U)) {
    case 0: asked.pdu = fields(3, address, 0); break;
    case 1: asked.pdu = fields(3, address, 126); break;
    case 2: asked.pdu = {3, 0, 0, 0}; break;
    case 3:
      asked.pdu = fields(4, 0xFFFF, 2);
      asked.refused = 2;
      break;
    case 4:
      asked.pdu = fields(0x83, address, 1);
      asked.refused = 1;
      break;
    default:
      asked.unit = 251;  // no route has it, and no serial line
      asked.pdu = fields(3, address, 1);
      asked.refused = 0x0A;
  }
  return asked;
}

}  // namespace mbgate::soak
