// SPDX-License-Identifier: Apache-2.0
// Plants in which much is said to all: clients that broadcast and stop often, drives of which only
// some take a broadcast for a stop or a value, a line that the route for all does not name. With a
// chance of its own, so that plants and clients stay those of the seed.
#include <algorithm>

#include "soak/plan.hpp"
#include "soak/registers.hpp"

namespace mbgate::soak {
namespace {

constexpr std::uint64_t kBroadcastsChance = 0x42434153ULL;
constexpr unsigned kFewAtOnce = 4;  // others would have nothing but broadcasts in their queues

// There the address of the AiC leads to nobody, because nobody may speak to all.
void name_fewer_lines(SoakPlan& plan, Random& random) {
  const auto route = std::ranges::find_if(plan.settings.routes, [](const routing::Route& it) {
    return it.is_broadcast() && it.buses.size() > 1;
  });
  if (route == plan.settings.routes.end()) {
    return;
  }
  const auto place = static_cast<std::size_t>(route - plan.settings.routes.begin());
  const auto by_autonics = std::ranges::find_if(
      plan.doors, [](const Door& door) { return door.route && door.only_autonics; });
  const auto left_out =
      by_autonics != plan.doors.end() && random.chance(600)
          ? by_autonics->buses.front()
          : static_cast<std::size_t>(route->buses[random.below(route->buses.size())]);
  std::erase(route->buses, drive::BusId{static_cast<std::uint32_t>(left_out)});
  for (Door& door : plan.doors) {
    if (door.only_autonics) {
      door.is_closed = door.is_closed || (door.route && door.buses.front() == left_out);
    } else if (door.route == place) {
      std::erase(door.buses, left_out);
    }
  }
}

void list_more(drive::Profile& profile, const Peculiarity& peculiar) {
  if (peculiar.stops) {
    profile.stops.push_back({Table::holding_registers, kBroadcastRegister, 0xF000, kStopOfSome});
  }
  if (peculiar.value) {
    profile.values.add({Table::holding_registers, kValueOfSome, 2, false});
  }
  if (profile.broadcast.allowed) {
    profile.broadcast.allowed->push_back({Table::holding_registers, kValueOfSome, 2});
  }
}

}  // namespace

void draw_broadcasts(SoakPlan& plan, std::uint64_t seed) {
  Random random(seed ^ kBroadcastsChance);
  plan.peculiar.resize(plan.settings.devices.size());
  if (plan.silence || !random.chance(300)) {
    return;
  }
  if (random.chance(500)) {
    name_fewer_lines(plan, random);
  }
  for (std::size_t index = 0; index < plan.peculiar.size(); ++index) {
    // Rules would have to know what touches what.
    if (plan.rules.empty()) {
      plan.peculiar[index] = {random.chance(500), random.chance(500)};
      list_more(plan.settings.devices[index].profile, plan.peculiar[index]);
    }
  }
  const unsigned broadcasts = random.one_of({100U, 300U});
  for (Manners& manners : plan.clients) {
    if (manners.outstanding <= kFewAtOnce) {
      manners.broadcasts = std::max(manners.broadcasts, broadcasts);
      manners.stops = std::max(manners.stops, random.one_of({0U, 50U, 150U}));
    }
  }
}

}  // namespace mbgate::soak
