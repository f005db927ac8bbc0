// SPDX-License-Identifier: Apache-2.0
// Drives that show their holding registers as input registers too, and rules that deny, or permit,
// only one of these: they mean both. With a chance of its own, so that plants and clients stay
// those of the seed.
#include "soak/access.hpp"
#include "soak/plan.hpp"

namespace mbgate::soak {
namespace {

constexpr std::uint64_t kTablesChance = 0x5441424C4553ULL;

}  // namespace

void draw_tables(SoakPlan& plan, std::uint64_t seed) {
  Random random(seed ^ kTablesChance);
  if (is_guarded(plan) || plan.silence || !random.chance(150)) {
    return;
  }
  for (drive::Device& device : plan.settings.devices) {
    device.profile.input_as_holding = random.chance(700);
  }
  SpokenRule rule{.permits = random.chance(300), .writes = random.chance(300), .any_role = true};
  const unsigned first = random.one_of({0U, random.between(0U, 60U)});
  rule.registers.spans.push_back(
      {.table = random.one_of({Table::holding_registers, Table::input_registers}),
       .first = first,
       .last = first + random.between(10U, 60U)});
  if (random.chance(300)) {
    rule.groups.push_back({.hosts = draw_hosts(random, 500)});
  }
  auto& rules = plan.rules;
  if (rules.empty()) {
    rules.push_back({.any_role = true});
  }
  rules.insert(rules.begin(), std::move(rule));
  if (rules.front().permits) {  // others may read none of these
    SpokenRule others = rules.front();
    others.permits = false;
    others.groups.clear();
    rules.insert(rules.begin() + 1, std::move(others));
  }
  // Those who look at the end how the gateway is.
  rules.insert(rules.begin(),
               {.writes = false, .groups = {{.hosts = {0}}}, .functions = {0x03, 0x04}});
  write_rules(plan);
}

}  // namespace mbgate::soak
