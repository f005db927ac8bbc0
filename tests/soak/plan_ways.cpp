// SPDX-License-Identifier: Apache-2.0
// Drives that work in order and slowly, and answers that come twice because two drives have one
// address or a repeater stands between. With a chance of their own, so that plants and clients stay
// those of the seed.
#include "soak/plan.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

namespace {

constexpr std::uint64_t kDrivesWaysChance = 0x57415953ULL;
constexpr std::uint64_t kKillsChance = 0x4B494C4C53ULL;
constexpr unsigned kSlow = 30;       // permille of drives
constexpr unsigned kSeconds = 40;    // the same
constexpr unsigned kRestarts = 120;  // of plants

}  // namespace

void draw_restarts(SoakPlan& plan, std::uint64_t seed) {
  Random random(seed ^ kKillsChance);
  plan.ways.resize(plan.settings.devices.size());
  if (random.chance(kRestarts)) {
    plan.restarts_every = random.one_of<Duration>({500ms, 3s, 10s});
    for (bus::BusSettings& bus : plan.settings.buses) {
      if (random.chance(700)) {
        bus.listen_first.reset();
      }
    }
  }
}

void draw_ways(SoakPlan& plan, std::uint64_t seed) {
  Random random(seed ^ kDrivesWaysChance);
  for (FaultRates& rates : plan.rates) {
    rates.refuses_stop = random.one_of({0U, 0U, 100U, 500U});
  }
  if (plan.theme != Theme::none) {
    return;
  }
  for (std::size_t index = 0; index < plan.ways.size(); ++index) {
    const Duration timeout = plan.settings.devices[index].timing.response_timeout;
    Ways& ways = plan.ways[index];
    if (random.chance(kSlow)) {
      ways.service = random.duration(timeout / 2, 5 * timeout);
    }
    if (random.chance(kSeconds)) {
      ways.second = random.between(50U, 1000U);
      ways.second_from = random.duration(1ms, timeout / 2);
      ways.second_to = ways.second_from + random.duration(0ms, plan.beyond ? timeout : 10ms);
    }
  }
}

}  // namespace mbgate::soak
