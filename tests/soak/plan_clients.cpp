// SPDX-License-Identifier: Apache-2.0
// The manners of one seed's clients.
#include "soak/plan.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

namespace {

unsigned some(Random& random, unsigned most) {
  return random.chance(300) ? 0 : static_cast<unsigned>(random.below(most + 1));
}

}  // namespace

void draw_clients(SoakPlan& plan, Random& random) {
  const unsigned hosts = random.between(1U, kMostHosts);
  // Most plants are calm: what is asked is mostly transmitted. Others are crowded.
  const bool is_calm = random.chance(750);
  for (unsigned count = random.one_of({2U, 6U, 12U, 30U}); count > 0; --count) {
    Manners manners;
    manners.listener = random.below(plan.settings.listeners.size());
    manners.host = static_cast<unsigned>(random.below(hosts));
    manners.burst = random.one_of({1U, 1U, 4U, 20U});
    manners.outstanding = random.one_of({1U, 4U, 40U, 100U});
    manners.pause = random.one_of<Duration>({1ms, 20ms, 200ms, 1s});
    if (is_calm) {
      manners.burst = random.one_of({1U, 1U, 2U});
      manners.outstanding = random.one_of({1U, 1U, 2U, 4U});
      manners.pause = random.one_of<Duration>({20ms, 50ms, 200ms, 1s});
      manners.least_pause = 5ms;
    }
    manners.writes = random.one_of({0U, 100U, 300U, 800U});
    manners.stops = random.one_of({0U, 0U, 10U, 60U});
    manners.broadcasts = random.one_of({0U, 0U, 10U, 50U});
    if (plan.silence) {
      manners.stops = manners.broadcasts = 0;
    }
    manners.malformed = some(random, 20);
    manners.foreign = some(random, 20);
    manners.splits = some(random, 300);
    manners.stalls = some(random, 20);
    manners.vanishes = some(random, 20);
    manners.half_closes = some(random, 10);
    manners.same_reads = random.one_of<std::uint16_t>({0, 0, 300, 900});
    plan.clients.push_back(manners);
    if (random.chance(150)) {
      manners.never_asks = true;
      manners.least_pause = 20ms;
      manners.pause = 1s;
      manners.vanishes = 200;
      plan.clients.push_back(manners);
    }
  }
}

}  // namespace mbgate::soak
