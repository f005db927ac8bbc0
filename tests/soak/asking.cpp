// SPDX-License-Identifier: Apache-2.0
#include "soak/asking.hpp"

#include <algorithm>

#include "soak/pdus.hpp"

namespace mbgate::soak {
namespace {

constexpr std::uint64_t kSeldomChance = 0x464F524D53ULL;  // apart from the clients'
constexpr std::uint64_t kNearChance = 0x4E454152ULL;
constexpr std::uint64_t kBootsChance = 0x424F4F5453ULL;
constexpr std::uint64_t kRareAsking = 0x52415245ULL;
constexpr std::uint64_t kPeculiarChance = 0x50454355ULL;
constexpr std::uint64_t kGatewayChance = 0x4F574E4552ULL;
constexpr std::uint64_t kEndsChance = 0x454E4453ULL;
constexpr unsigned kBeyond = 30;  // permille of requests, where any end behind the last address
constexpr unsigned kByAutonics = 200;  // permille of broadcasts, where there is such a door

}  // namespace

Asking::Asking(const SoakPlan& plan, Random& random)
    : plan_(plan),
      random_(random),
      counters_(plan.settings.devices.size()),
      device_doors_(plan.settings.listeners.size()),
      broadcast_doors_(plan.settings.listeners.size()),
      autonics_doors_(plan.settings.listeners.size()),
      forms_(plan.seed ^ kSeldomChance),
      near_(plan.seed ^ kNearChance),
      boots_(plan.seed ^ kBootsChance),
      rare_(plan.seed ^ kRareAsking),
      peculiar_(plan.seed ^ kPeculiarChance),
      gateway_(plan.seed ^ kGatewayChance),
      ends_(plan.seed ^ kEndsChance) {
  goes_beyond_ = plan.theme == Theme::none && ends_.chance(250);
  for (const Door& door : plan.doors) {
    auto& doors = door.device          ? device_doors_
                  : door.only_autonics ? autonics_doors_
                                       : broadcast_doors_;
    doors[door.listener].push_back(&door);
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

// One that it asks.
const Door& Asking::door_for(const Manners& manners) {
  if (manners.devices.empty()) {
    return *door_of(manners.listener, false);
  }
  std::vector<const Door*> doors;
  for (const Door* door : device_doors_[manners.listener]) {
    if (!door->absent && std::ranges::count(manners.devices, *door->device) > 0) {
      doors.push_back(door);
    }
  }
  return *doors[random_.below(doors.size())];
}

Asked Asking::make(const Manners& manners) {
  if (manners.watches > 0 && forms_.chance(manners.watches)) {
    return health();
  }
  if (manners.asks_gateway > 0 && gateway_.chance(manners.asks_gateway)) {
    return of_gateway(manners);
  }
  const auto& readers = plan_.readers[manners.listener];
  may_only_read_ = std::ranges::find(readers, manners.host) != readers.end();
  const Door& door = door_for(manners);
  if (door.absent) {
    return door.route ? for_nobody(door) : own_read(0, 4);
  }
  if (goes_beyond_ && ends_.chance(kBeyond)) {
    return beyond_last(door);
  }
  if (random_.chance(manners.malformed)) {
    return random_.chance(200) ? own() : malformed(door);
  }
  if (random_.chance(manners.broadcasts)) {
    const Door* all = door_of(manners.listener, true);
    const auto& others = autonics_doors_[manners.listener];
    if (!others.empty() && forms_.chance(kByAutonics)) {
      all = others[forms_.below(others.size())];
    }
    if (all != nullptr && !all->absent && (!all->only_autonics || hears_autonics(*all))) {
      return broadcast(*all);
    }
  }
  if (random_.chance(manners.stops)) {
    return stop(door, manners.same_stops);
  }
  const bool is_alike = manners.alike > 0 && near_.chance(manners.alike);
  if (random_.chance(manners.writes)) {
    return is_alike ? alike_write(door) : write(door);
  }
  if (is_alike) {
    return alike_read(door);
  }
  const bool popular = random_.chance(manners.same_reads);
  return near_.chance(manners.near_reads) ? near_read(door) : read(door, popular);
}

Asked Asking::fresh_read(const Door& door) {
  may_only_read_ = false;
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

void Asking::add_piece(Asked& asked, PduBytes pdu) const {
  asked.pieces.push_back(
      {asked.door->buses.front(), device_of(asked).address, std::move(pdu), 0, false, false});
}

std::uint16_t Asking::next_value(const Asked& asked, unsigned address) {
  std::uint16_t& counter = counters_[*asked.door->device].at(address);
  counter = static_cast<std::uint16_t>(counter + (counter + 1 == kPositionOpcode ? 2 : 1));
  return counter;
}

void Asking::refuse_if_read_only(Asked& asked) const {
  if (asked.door->read_only || may_only_read_) {
    asked.refused = 1;
    asked.pieces.clear();
  }
}

// Functions that the profile does not name are refused where the route names none itself. What is
// beyond its windows is said before.
void Asking::check_functions(Asked& asked) const {
  const Door& door = *asked.door;
  if (!door.routed || asked.refused == 1 || asked.refused == 2) {
    return;
  }
  const auto& known = device_of(asked).profile.functions;
  const bool all_known = (asked.pdu[0] == 0x03 || known.test(asked.pdu[0])) &&
                         std::ranges::all_of(asked.pieces, [&](const Piece& piece) {
                           return known.test(piece.pdu[0]);
                         });
  if (!all_known) {
    asked.refused = 1;
    asked.pieces.clear();
  }
}

// What the gateway shows of one device: its bus, address and state, and how often in a row it was
// silent.
Asked Asking::health() {
  const std::size_t device = forms_.below(plan_.settings.devices.size());
  return own_read(static_cast<std::uint16_t>(kDevicesAt + kDeviceSize * device), kShownOfHealth);
}

// Who is denied everything does not set its counters to 0 either.
Asked Asking::of_gateway(const Manners& manners) {
  constexpr unsigned kClear = 10;
  if (gateway_.chance(500)) {
    return own_read(0, 4);
  }
  const bool is_denied = manners.role.kind == routing::ClientRole::Kind::unreadable;
  Asked asked = own_read(0, 4);
  asked.any_code = true;
  asked.pdu = is_denied && gateway_.chance(500)
                  ? fields(8, kClear, 0)
                  : gateway_.one_of<PduBytes>({{0x2B, 0x0E, 1, 0}, fields(8, 0, 0x1234)});
  return asked;
}

// The gateway answers itself, rightly or with an exception, and passes nothing on.
Asked Asking::own() {
  constexpr unsigned kEchoes = 0;
  Asked asked = own_read(0, 4);
  asked.any_code = true;
  switch (random_.between(0U, 5U)) {
    case 0: asked.pdu = fields(8, random_.one_of({kEchoes, 2U, 11U, 12U, 14U, 18U, 19U}), 0); break;
    case 1:
      asked.pdu = {0x2B, 0x0E, low(random_.between(0U, 5U)), low(random_.between(0U, 8U))};
      break;
    case 2: asked.pdu = fields(random_.one_of({1U, 3U, 6U}), 0, 1); break;
    case 3: asked.pdu = {0x11}; break;
    default: asked.pdu = fields(4, random_.between(0U, 0xFFFFU), random_.between(1U, 125U)); break;
  }
  return asked;
}

Asked Asking::malformed(const Door& door) {
  Asked asked = begin(door, Kind::read);
  const unsigned address = door.holding_at;
  if (door.windowed && rare_.chance(150)) {  // what is read there cannot be written
    asked.refused = 1;
    asked.pdu = fields(6, door.input_at + rare_.below(kInputs), 1);
    return asked;
  }
  asked.refused = 3;
  switch (random_.between(0U, 10U)) {
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
    case 5:
      asked.pdu = random_.one_of<PduBytes>({{0x10, 0, 0, 0, 2, 3, 1, 1, 1},
                                            {0x10, 0, 0, 0, 2, 3, 1, 1, 1, 1},
                                            {0x10, 0, 0, 0, 2, 4, 1, 1, 1}});
      break;
    case 6: asked.pdu = fields(5, 1, 0x1234); break;
    case 7: {
      const unsigned sub_function = random_.one_of({1U, 4U, 21U});
      asked.pdu = fields(8, may_be_silenced(door, sub_function) ? 21U : sub_function, 0);
      asked.refused = 1;
      break;
    }
    case 8:
      asked.pdu = fields(0, 0, 0);
      asked.refused = 1;
      break;
    case 9:
      // Over the end of a window, or of the table.
      asked.pdu = fields(3, door.windowed ? door.holding_at + kRegisters - 1U : 0xFFFFU, 2);
      asked.refused = 2;
      break;
    default:
      asked.unit = 251;  // no route has it, and no serial line
      asked.pdu = fields(3, address, 1);
      asked.refused = 0x0A;
      return asked;
  }
  if (asked.refused == 3 && (door.read_only || may_only_read_) &&
      (asked.pdu[0] == 0x10 || asked.pdu[0] == 5)) {
    asked.refused = 1;
  }
  return asked;
}

}  // namespace mbgate::soak
