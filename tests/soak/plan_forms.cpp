// SPDX-License-Identifier: Apache-2.0
// What few plants have: drives that show few coils at once, word orders of broadcasts, clients that
// ask for address 129, listeners where nobody may speak to all. With a chance of its own, so that
// plants and clients stay those of the seed.
#include <algorithm>

#include "soak/plan.hpp"
#include "soak/registers.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

namespace {

constexpr std::uint64_t kFormsChance = 0x504C414EULL;

// An AiC listens there, or will.
void add_autonics_doors(SoakPlan& plan) {
  const std::vector<Door> doors = plan.doors;
  for (Door door : doors) {
    const bool is_straight = !door.device && !door.route;
    if (is_straight && is_for_all(plan, door.buses.front(), kAutonicsAddress)) {
      door.unit = kAutonicsAddress;
      door.only_autonics = true;
      plan.doors.push_back(door);
    }
  }
}

void draw_misfits(FaultRates& rates, Random& random) {
  const unsigned most = random.one_of({0U, 10U, 30U, 100U});
  rates.too_short = static_cast<unsigned>(random.below(most + 1));
  rates.wrong_echo = static_cast<unsigned>(random.below(most + 1));
}

// A line that is silent for a while is opened again, whether it hangs or nobody answers there.
void draw_hangs(SoakPlan& plan, std::size_t bus, Random& random) {
  bus::BusSettings& settings = plan.settings.buses[bus];
  if (settings.line.framing == bus::Framing::tcp || !random.chance(300)) {
    return;
  }
  settings.hung_after = random.duration(500ms, 4s);
  settings.hung_requests = random.between(2U, 10U);
  settings.hung_max = random.duration(settings.hung_after, 8 * settings.hung_after);
  plan.rates[bus].hangs_every = random.chance(700) ? random.duration(1s, 10s) : 0ms;
}

}  // namespace

void draw_forms(SoakPlan& plan, std::uint64_t seed) {
  Random random(seed ^ kFormsChance);
  for (drive::Device& device : plan.settings.devices) {
    if (random.chance(300)) {
      auto& read = device.profile.limits.read;
      read[0] = random.between<std::uint16_t>(7, 60);
      read[1] = random.between<std::uint16_t>(7, 60);
    }
  }
  for (std::size_t bus = 0; bus < plan.settings.buses.size(); ++bus) {
    draw_misfits(plan.rates[bus], random);
    draw_hangs(plan, bus, random);
    plan.rates[bus].breaks_framing = random.one_of({0U, 0U, 5U, 50U});
  }
  for (gateway::ListenerSettings& listener : plan.settings.listeners) {
    listener.broadcast = listener.broadcast && !random.chance(150);
    listener.broadcast_mixed = true;
  }
  for (routing::Route& route : plan.settings.routes) {
    if (route.is_broadcast() && random.chance(600)) {
      route.word_order = random.one_of({drive::WordOrder::big, drive::WordOrder::little});
    }
  }
  for (Door& door : plan.doors) {
    if (!door.device) {
      door.names_order = door.route && plan.settings.routes[*door.route].word_order;
      door.is_closed = !door.route && !plan.settings.listeners[door.listener].broadcast;
    }
  }
  for (routing::Route& route : plan.settings.routes) {
    const bool is_plain = !route.is_broadcast() && route.windows.empty();
    route.functions.force_listen_only = is_plain && random.chance(300);
  }
  for (std::size_t bus = 0; bus < plan.settings.buses.size(); ++bus) {
    const bool is_auto = plan.echoes[bus] && !plan.settings.buses[bus].line.echo;
    if (is_auto && random.chance(160)) {
      plan.rates[bus].echo_lost = 400;
    }
  }
  add_autonics_doors(plan);
}

}  // namespace mbgate::soak
