// SPDX-License-Identifier: Apache-2.0
#include "soak/access.hpp"

#include <algorithm>
#include <utility>

#include "soak/from_world.hpp"
#include "soak/plan.hpp"
#include "soak/registers.hpp"

namespace mbgate::soak {
namespace {

constexpr std::uint64_t kAccessChance = 0x414343455353ULL;
constexpr std::uint64_t kWritersChance = 0x57524954455253ULL;
constexpr std::uint8_t kReadWrite = 0x17;

// Nobody in particular, or one group.
std::vector<SpokenGroup> draw_group(Random& random, unsigned permille) {
  auto hosts = draw_hosts(random, permille);
  return hosts.empty() ? std::vector<SpokenGroup>{}
                       : std::vector<SpokenGroup>{{.hosts = std::move(hosts)}};
}

routing::AccessRule written_rule(const SpokenRule& spoken) {
  routing::AccessRule rule;
  rule.permits = spoken.permits;
  rule.access = spoken.reads == spoken.writes ? routing::RuleAccess::both
                : spoken.reads                ? routing::RuleAccess::read
                                              : routing::RuleAccess::write;
  for (const SpokenGroup& group : spoken.groups) {
    rule.clients.push_back({"group", networks_of(group.hosts), group.roles});
  }
  rule.roles = spoken.roles;
  rule.any_role = spoken.any_role;
  for (const std::size_t listener : spoken.listeners) {
    rule.listeners.push_back(gateway::ListenerId{static_cast<std::uint32_t>(listener)});
  }
  rule.devices = spoken.devices;
  if (!spoken.units.empty()) {
    rule.units.emplace();
    for (const std::uint8_t unit : spoken.units) {
      rule.units->set(unit);
    }
  }
  if (!spoken.functions.empty()) {
    rule.functions.emplace();
    for (const std::uint8_t function : spoken.functions) {
      rule.functions->set(function);
    }
  }
  for (const SpokenSpan& span : spoken.registers.spans) {
    rule.registers.spans.push_back({span.table, static_cast<std::uint16_t>(span.first),
                                    static_cast<std::uint16_t>(span.last)});
  }
  rule.registers.motion_commands = spoken.registers.motion;
  rule.registers.communication_registers = spoken.registers.communication;
  rule.registers.values = spoken.registers.values;
  rule.registers.stops = spoken.registers.stops;
  rule.per_second = spoken.rate;
  return rule;
}

// Some hosts may write nothing, to a device, through a listener or at all; others what a rule
// names.
void draw_writers(SoakPlan& plan, std::uint64_t seed) {
  Random random(seed ^ kWritersChance);
  if (!is_guarded(plan) || !random.chance(300)) {
    return;
  }
  for (unsigned count = random.between(1U, 3U); count > 0; --count) {
    SpokenRule& rule = plan.rules.emplace_back();
    rule.permits = random.chance(300);
    rule.reads = false;
    rule.groups = draw_group(random, 400);
    const std::size_t device = random.below(plan.settings.devices.size());
    if (random.chance(500) && !plan.failsafe[device].empty()) {
      rule.devices = {device};
    }
    if (random.chance(400)) {
      rule.listeners = {random.below(plan.settings.listeners.size())};
    }
    if (random.chance(300)) {
      rule.functions = {0x06, 0x10};
    }
  }
  plan.rules.push_back({.writes = random.chance(700)});
  write_rules(plan);
}

}  // namespace

std::vector<unsigned> draw_hosts(Random& random, unsigned permille) {
  std::vector<unsigned> hosts;
  for (unsigned host = 0; host < kMostHosts; ++host) {
    if (random.chance(permille)) {
      hosts.push_back(host);
    }
  }
  return hosts;
}

std::vector<std::uint8_t> draw_units(const SoakPlan& plan, Random& random) {
  std::vector<std::uint8_t> units;
  for (const Door& door : plan.doors) {
    if (door.device && random.chance(300)) {
      units.push_back(door.unit);
    }
  }
  return units;
}

void write_rules(SoakPlan& plan) {
  plan.settings.rules.clear();
  for (const SpokenRule& rule : plan.rules) {
    plan.settings.rules.push_back(written_rule(rule));
  }
}

bool is_guarded(const SoakPlan& plan) {
  return std::ranges::any_of(plan.failsafe, [](const auto& it) { return !it.empty(); });
}

void draw_access(SoakPlan& plan, std::uint64_t seed) {
  draw_writers(plan, seed);
  Random random(seed ^ kAccessChance);
  if (is_guarded(plan) || !random.chance(300)) {
    return;
  }
  if (random.chance(500)) {
    plan.rules.push_back({.permits = false,
                          .groups = draw_group(random, 300),
                          .functions = random.one_of<std::vector<std::uint8_t>>(
                              {{0x16}, {kReadWrite}, {0x2B, kOwnFunction}, {0x07, 0x08, 0x11}})});
  }
  // A rule that is about units names only what is never asked of all at once.
  auto units = draw_units(plan, random);
  if (!units.empty() && random.chance(600)) {
    plan.rules.push_back({.permits = false,
                          .writes = false,
                          .groups = draw_group(random, 400),
                          .units = std::move(units),
                          .functions = random.one_of<std::vector<std::uint8_t>>(
                              {{0x01}, {0x02, 0x04}, {0x01, 0x02, 0x04}})});
  }
  if (random.chance(300)) {
    plan.rules.push_back({.permits = false,
                          .writes = false,
                          .groups = draw_group(random, 500),
                          .functions = {kReadWrite}});
  }
  const auto others = draw_hosts(random, 300);
  if (!others.empty() && random.chance(500)) {
    plan.rules.push_back({.permits = false, .reads = false, .groups = {{.hosts = others}}});
  }
  if (random.chance(300)) {
    plan.rules.push_back({.reads = false,
                          .groups = draw_group(random, 600),
                          .functions = {0x05, 0x06, 0x0F, 0x10, kReadWrite}});
    plan.rules.push_back({.writes = false});
  } else {
    plan.rules.push_back({});
  }
  write_rules(plan);
}

}  // namespace mbgate::soak
