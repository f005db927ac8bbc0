// SPDX-License-Identifier: Apache-2.0
// What goes wrong on few lines only: drives that answer before they boot, late answers in ASCII
// within which a request is sent. With a chance of its own, so that plants and clients stay those
// of the seed.
#include <algorithm>

#include "soak/plan.hpp"

namespace mbgate::soak {

namespace {

constexpr std::uint64_t kRarePlan = 0x52415245ULL;  // apart from the plant's

// On a line that hears nothing else, and at once.
void straddle(SoakPlan& plan, std::size_t bus, Random& random) {
  FaultRates& rates = plan.rates[bus];
  rates.straddles = 800;
  rates.late = std::max(rates.late, 200U);
  rates.noise_every = rates.foreign_every = rates.babbles_every = {};
  plan.adapters[bus] = AdapterKind::uart;
  plan.echoes[bus] = false;
  plan.settings.buses[bus].line.echo = random.chance(500) ? std::optional(false) : std::nullopt;
}

// It keeps its connection for long, and so does the gateway.
void overload(SoakPlan& plan, std::size_t bus) {
  FaultRates rates;
  rates.overload = 70;
  rates.boots_answered = plan.rates[bus].boots_answered;
  plan.rates[bus] = rates;
  plan.settings.buses[bus].replace_after = 0;
}

// Only where its echo is looked for, and where nothing else makes it doubtful.
void flicker(SoakPlan& plan, std::size_t bus) {
  FaultRates& rates = plan.rates[bus];
  rates.echo_flickers = 500;
  rates.echo_lost = rates.echo_cut = rates.echo_damaged = rates.prompt = 0;
  rates.noise_every = rates.foreign_every = rates.babbles_every = rates.hangs_every = {};
  rates.lost_every = {};
}

}  // namespace

void draw_rare_faults(SoakPlan& plan, std::uint64_t seed) {
  Random random(seed ^ kRarePlan);
  for (std::size_t bus = 0; bus < plan.rates.size(); ++bus) {
    FaultRates& rates = plan.rates[bus];
    rates.boots_answered = random.one_of({0U, 0U, 800U});
    const bus::LineSettings& line = plan.settings.buses[bus].line;
    if (line.framing == bus::Framing::tcp && random.chance(400)) {
      overload(plan, bus);
    }
    if (plan.echoes[bus] && !line.echo && random.chance(400)) {
      flicker(plan, bus);
    }
    if (line.framing == bus::Framing::ascii) {
      rates.other_length = random.one_of({0U, 0U, 60U});
      if (random.chance(500)) {
        straddle(plan, bus, random);
      }
    }
  }
}

}  // namespace mbgate::soak
