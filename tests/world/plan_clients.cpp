// SPDX-License-Identifier: Apache-2.0
// The manners of a plant's clients.
#include "world/plan_parts.hpp"

namespace mbgate::world {

using namespace std::chrono_literals;

void draw_clients(Plan& plan, Random& random) {
  const unsigned hosts = random.between(1U, kMostHosts);
  const bool is_calm = random.chance(800);
  const unsigned odd = random.one_of({0U, 5U, 20U});
  const auto some = [&](unsigned most) {
    return random.chance(500) ? 0U : static_cast<unsigned>(random.below(most + 1));
  };
  for (unsigned count = random.one_of({2U, 4U, 8U, 16U}); count > 0; --count) {
    Manners manners;
    manners.listener = random.below(plan.settings.listeners.size());
    manners.host = static_cast<unsigned>(random.below(hosts));
    manners.burst = is_calm ? random.between(1U, 2U) : random.one_of({1U, 4U, 12U});
    manners.outstanding = is_calm ? random.between(1U, 4U) : random.one_of({1U, 8U, 20U});
    manners.pause = is_calm ? random.one_of<Duration>({20ms, 50ms, 200ms, 1s})
                            : random.one_of<Duration>({1ms, 20ms, 200ms});
    manners.writes = random.one_of({0U, 100U, 300U, 800U});
    manners.stops = random.one_of({0U, 0U, 20U, 100U});
    manners.broadcasts = random.one_of({0U, 0U, 10U, 50U});
    manners.malformed = some(odd);
    manners.same_reads = random.one_of({0U, 300U, 900U});
    manners.splits = some(200);
    manners.foreign = some(odd);
    manners.vanishes = some(odd);
    manners.half_closes = some(odd / 2);
    manners.stalls = some(odd);
    if (random.chance(200)) {
      manners.patience = random.duration(50ms, 2s);
      manners.repeats = random.chance(500);
    }
    const auto& listener = plan.settings.listeners[manners.listener];
    if (listener.one_at_a_time && manners.patience == Duration{0}) {
      manners.patience = 1s;
    }
    plan.clients.push_back(manners);
  }
}

}  // namespace mbgate::world
