// SPDX-License-Identifier: Apache-2.0
#include "world/asking.hpp"

#include <algorithm>

#include "world/rights.hpp"

namespace mbgate::world {

// The registers of a value have no word in common: a write that was asked for in one word order may
// go out in another.
std::uint16_t Asking::next(std::size_t place, unsigned address) {
  return ++counters_[std::uint64_t{place} << 32U | value_begin(address)];
}

std::optional<std::size_t> Asking::pick_door(const Manners& manners, bool broadcast) {
  std::vector<std::size_t> doors;
  for (std::size_t at = 0; at < plan_.doors.size(); ++at) {
    const Door& door = plan_.doors[at];
    const bool is_asked = manners.stations.empty() || !door.station ||
                          std::ranges::count(manners.stations, *door.station) > 0;
    if (door.listener == manners.listener && door.station.has_value() != broadcast && is_asked) {
      doors.push_back(at);
    }
  }
  return doors.empty() ? std::nullopt : std::optional(doors[random_.below(doors.size())]);
}

Intent Asking::begin(std::size_t at, Kind kind) const {
  const Door& door = plan_.doors[at];
  Intent intent;
  intent.kind = kind;
  intent.door = at;
  intent.unit = door.unit;
  intent.station = door.station;
  intent.buses = door.buses;
  intent.swapped = door.swapped;
  intent.whole = !door.routed;
  intent.answer_due = door.replies;
  return intent;
}

Intent Asking::of_gateway(const Octets& pdu) {
  Intent intent;
  intent.kind = Kind::own;
  intent.unit = 255;  // the status unit
  intent.pdu = pdu;
  return intent;
}

Intent Asking::make(const Manners& manners) {
  const auto door = pick_door(manners, false);
  if (!door) {
    return of_gateway(request(4, 0, 4));
  }
  Intent intent;
  if (random_.chance(manners.malformed)) {
    return malformed(*door);
  }
  const auto all = random_.chance(manners.broadcasts) ? pick_door(manners, true) : std::nullopt;
  if (all) {
    intent = broadcast(*all);
  } else if (random_.chance(manners.stops)) {
    intent = stop(*door);
  } else if (random_.chance(manners.writes)) {
    intent = write(*door, manners.plain);
  } else {
    intent = read(*door, random_.chance(manners.same_reads));
  }
  check_rights(intent, manners.listener, manners.host);
  if (intent.whole) {
    intent.sent = intent.pdu;
  }
  return intent;
}

void Asking::may_refuse(Intent& intent, unsigned codes) {
  intent.codes = static_cast<std::uint16_t>(intent.codes | codes);
}

void Asking::refuse(Intent& intent, unsigned codes) {
  intent.refused = true;
  may_refuse(intent, codes);
}

void Asking::check_rights(Intent& intent, std::size_t listener, unsigned host) const {
  const bool is_sound = !intent.refused;
  const auto& readers = plan_.readers[listener];
  const bool may_write = std::ranges::count(readers, host) == 0 && !door_of(intent).read_only;
  const Verdict verdict = verdict_of(plan_, intent, listener, host);
  if (!verdict.permitted || (intent.kind != Kind::read && !may_write)) {
    refuse(intent, code(1));
  } else if (!verdict.sure) {
    may_refuse(intent, code(1));
  }
  if (intent.station) {
    check_station(intent, host);
  }
  intent.rated = intent.refused ? std::vector<std::size_t>{} : verdict.rated;
  intent.denied = is_sound && intent.refused;
}

void Asking::check_station(Intent& intent, unsigned host) const {
  const Door& door = door_of(intent);
  const Station& station = plan_.stations[*intent.station];
  const bool is_writer =
      intent.kind != Kind::write || !station.device ||
      plan_.settings.guards[*station.device].writer != gateway::WriterRule::listed ||
      std::ranges::count(plan_.writers[*station.device], host) > 0;
  if (!is_writer) {
    refuse(intent, code(1) | code(6));
  }
  if (!door.routed) {
    return;
  }
  const drive::Device& device = device_of(intent);
  const auto& functions = door.functions ? *door.functions : device.profile.functions;
  if (!functions.test(intent.pdu[0])) {
    refuse(intent, code(1));
  }
  if (device.verify_word_order) {
    may_refuse(intent, code(4));
  }
}

Intent Asking::fresh_read(std::size_t door) const {
  Intent intent = begin(door, Kind::read);
  plan_read(intent, Table::holding_registers, kLiveFrom, 4);
  if (intent.whole) {
    intent.sent = intent.pdu;
  }
  return intent;
}

Intent Asking::read(std::size_t door, bool popular) {
  Intent intent = begin(door, Kind::read);
  if (popular) {
    plan_read(intent, Table::holding_registers, kLiveFrom, 4);
    return intent;
  }
  const unsigned kind = random_.between(0U, 19U);
  if (kind == 0) {
    return nameless_read(door);
  }
  if (kind == 1) {
    const unsigned count = random_.between(1U, 40U);
    plan_read(intent, random_.one_of({Table::coils, Table::coils, Table::discrete_inputs}),
              random_.between(0U, kCoils - count), count);
  } else if (kind <= 5) {
    plan_read(intent, Table::input_registers, random_.between(0U, 70U), random_.between(1U, 30U));
  } else {
    const unsigned count =
        random_.chance(100) ? random_.between(30U, 120U) : random_.between(1U, 12U);
    const bool lives = random_.chance(500);
    plan_read(intent, Table::holding_registers,
              lives ? kLiveFrom + random_.below(20U) : random_.between(0U, kRegisters - count),
              count);
  }
  return intent;
}

void Asking::plan_read(Intent& intent, Table table, unsigned first, unsigned count) const {
  const Door& door = door_of(intent);
  constexpr std::array kFunctions{1U, 2U, 3U, 4U};  // by table
  const auto place = static_cast<std::size_t>(table);
  intent.reads = Range{table, first, count};
  if (door.windowed && table == Table::input_registers) {
    intent.pdu = request(3, first + door.input_at, count);
  } else {
    const unsigned shift = table == Table::holding_registers ? door.holding_at : 0;
    intent.pdu = request(kFunctions.at(place), first + shift, count);
  }
  if (door.windowed && table == Table::discrete_inputs) {
    refuse(intent, code(1) | code(2));
  }
}

Intent Asking::nameless_read(std::size_t at) {
  constexpr std::uint8_t kOfNobody = 198;  // a register that no rule names
  Intent intent = begin(at, Kind::read);
  intent.pdu = random_.one_of<Octets>({{0x07},
                                       {0x0B},
                                       {0x11},
                                       {0x0C},
                                       {0x14, 7, 6, 0, 1, 0, 0, 0, 2},
                                       {0x2B, kIdentification, 1, 0},
                                       {0x18, 0, kOfNobody}});
  if (intent.pdu[0] == 0x18 && door_of(intent).windowed) {
    intent.pdu = {0x07};
  }
  intent.is_odd_read = true;
  if (door_of(intent).windowed) {
    refuse(intent, code(1));
  }
  return intent;
}

Intent Asking::malformed(std::size_t at) {
  Intent intent = begin(at, Kind::read);
  intent.whole = false;
  intent.kind = Kind::write;
  const unsigned address = door_of(intent).holding_at;
  unsigned codes = code(1) | code(2) | code(3);
  switch (random_.between(0U, 8U)) {
    case 0: intent.pdu = request(3, address, 0); break;
    case 1: intent.pdu = request(3, address, 126); break;
    case 2: intent.pdu = {3, 0, 0, 0}; break;
    case 3: intent.pdu = request(4, 0xFFFF, 2); break;
    case 4: intent.pdu = request(0x83, address, 1); break;
    case 5: intent.pdu = {0x10, 0, 0, 0, 2, 3, 1, 1, 1}; break;
    case 6: intent.pdu = request(5, 1, 0x1234); break;
    case 7: intent.pdu = request(8, random_.one_of({1U, 4U, 21U}), 0); break;  // named nowhere
    default:
      intent.unit = 251;  // nobody's
      intent.pdu = request(3, address, 1);
      codes = code(0x0A) | (plan_.rules.empty() ? 0U : code(1));
      break;
  }
  refuse(intent, codes);
  return intent;
}

}  // namespace mbgate::world
