// SPDX-License-Identifier: Apache-2.0
// What comes in part: late answers with pauses, and those of servers that close the connection
// within one; lines that damage one answer after the other, or come back with another adapter. With
// chances of their own, so that plants and clients stay those of the seed.
#include "soak/plan.hpp"

namespace mbgate::soak {

namespace {

constexpr std::uint64_t kLateChance = 0x4C415445ULL;
constexpr std::uint64_t kDamageChance = 0x44414D414745ULL;
constexpr std::uint64_t kSwapChance = 0x53574150ULL;

// Most come in time, and with a bad CRC: their devices are there. If others never come, what is
// damaged brings nobody back.
void damage_many(FaultRates& rates, Random& random) {
  rates.bad_crc = random.one_of({300U, 600U, 850U});
  rates.never = random.one_of({0U, 0U, 300U});
  rates.damaged = rates.request_damaged = rates.garbage = 0;
  rates.noise_every = rates.foreign_every = {};
}

}  // namespace

void draw_late(SoakPlan& plan, std::uint64_t seed) {
  Random random(seed ^ kLateChance);
  Random damage(seed ^ kDamageChance);
  Random swap(seed ^ kSwapChance);
  for (FaultRates& rates : plan.rates) {
    rates.breaks_off = random.one_of({0U, 0U, 5U, 50U});
    rates.late_pieces = random.one_of({0U, 100U, 500U});
    if (damage.chance(60)) {
      damage_many(rates, damage);
    }
    rates.are_quick = swap.chance(250);
    rates.stuck = swap.one_of({0U, 30U, 100U});
    rates.swapped = swap.one_of({0U, 0U, 500U});
  }
}

}  // namespace mbgate::soak
