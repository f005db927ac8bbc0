// SPDX-License-Identifier: Apache-2.0
// Who may speak to all through routes, at address 129 too; which routes let clients silence a
// device; stops that have a parameter. With a chance of its own, so that plants and clients stay
// those of the seed.
#include <algorithm>

#include "soak/plan.hpp"
#include "soak/registers.hpp"

namespace mbgate::soak {
namespace {

constexpr std::uint64_t kOddsChance = 0x4F444453ULL;

bool is_free(const SoakPlan& plan, std::uint8_t unit) {
  return std::ranges::none_of(plan.settings.routes, [&](const routing::Route& route) {
    return route.first_unit <= unit && unit <= route.last_unit;
  });
}

// A route to the address where the AiC listens is a way to all of them, for those who may speak to
// all; what it allows itself holds too.
void add_autonics_route(SoakPlan& plan, Random& random) {
  const auto all = std::ranges::find_if(plan.doors, [](const Door& door) {
    return door.route && !door.device && !door.only_autonics;
  });
  if (all == plan.doors.end() || !is_free(plan, kAutonicsAddress)) {
    return;
  }
  const auto bus = std::ranges::find_if(
      all->buses, [&](std::size_t it) { return is_for_all(plan, it, kAutonicsAddress); });
  if (bus == all->buses.end()) {
    return;
  }
  Door door = *all;
  door.unit = kAutonicsAddress;
  door.only_autonics = true;
  door.buses = {*bus};
  const bool only_reads = random.chance(500);
  door.read_only = all->read_only || only_reads;
  routing::Route& route = plan.settings.routes.emplace_back();
  route.first_unit = route.last_unit = route.first_address = kAutonicsAddress;
  route.buses = {drive::BusId{static_cast<std::uint32_t>(*bus)}};
  route.access = only_reads ? routing::Access::read_only : routing::Access::read_write;
  plan.absent.routes.push_back(false);
  for (; !plan.settings.listeners[door.listener].bus; ++door.listener) {
    plan.doors.push_back(door);
  }
}

}  // namespace

void draw_odds(SoakPlan& plan, std::uint64_t seed) {
  Random random(seed ^ kOddsChance);
  for (drive::Device& device : plan.settings.devices) {
    device.profile.stops.front().parameters = random.chance(500) ? 1 : 0;
  }
  for (std::size_t index = 0; index < plan.settings.routes.size(); ++index) {
    routing::Route& route = plan.settings.routes[index];
    route.broadcast_mixed = true;
    if (route.is_broadcast() && random.chance(80)) {
      route.access = routing::Access::read_only;
      for (Door& door : plan.doors) {
        door.read_only = door.read_only || door.route == index;
      }
    } else if (!route.is_broadcast() && route.windows.empty()) {
      route.functions.restart_communications = random.chance(400);
    }
  }
  add_autonics_route(plan, random);
}

}  // namespace mbgate::soak
