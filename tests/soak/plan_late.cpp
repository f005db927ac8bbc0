// SPDX-License-Identifier: Apache-2.0
// What comes in part: late answers with pauses, and those of servers that close the connection
// within one. With a chance of its own, so that plants and clients stay those of the seed.
#include "soak/plan.hpp"

namespace mbgate::soak {

namespace {

constexpr std::uint64_t kLateChance = 0x4C415445ULL;

}  // namespace

void draw_late(SoakPlan& plan, std::uint64_t seed) {
  Random random(seed ^ kLateChance);
  for (FaultRates& rates : plan.rates) {
    rates.breaks_off = random.one_of({0U, 0U, 5U, 50U});
    rates.late_pieces = random.one_of({0U, 100U, 500U});
  }
}

}  // namespace mbgate::soak
