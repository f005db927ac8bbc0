// SPDX-License-Identifier: Apache-2.0
// Rules about devices, registers, listeners, groups and roles, in any combination; about the units
// of broadcasts, and how often they permit something. With chances of their own.
#include <algorithm>
#include <utility>

#include "soak/access.hpp"
#include "soak/from_world.hpp"
#include "soak/plan.hpp"
#include "soak/registers.hpp"

namespace mbgate::soak {
namespace {

constexpr std::uint64_t kCloseChance = 0x434C4F5345ULL;
constexpr std::uint64_t kRatesChance = 0x5241544553ULL;
constexpr std::uint64_t kAloneChance = 0x414C4F4E45ULL;
constexpr std::uint8_t kBothAtOnce = 0x17;

// On a listener with TLS everybody has a role, and the host alone decides which.
void give_roles(SoakPlan& plan, std::size_t listener, unsigned permille, Random& random) {
  using enum routing::ClientRole::Kind;
  plan.settings.listeners[listener].tls = 0;
  std::vector<routing::ClientRole> roles;
  for (unsigned host = 0; host < kMostHosts; ++host) {
    roles.push_back(
        random.chance(permille)
            ? routing::ClientRole{unreadable}
            : routing::ClientRole{named, random.one_of<std::string>({"", "operator", "viewer"})});
  }
  for (Manners& manners : plan.clients) {
    if (manners.listener == listener) {
      manners.role = roles[manners.host];
    }
  }
}

// Rules about devices, registers, listeners, groups and roles, in any combination.
class CloseAccess {
 public:
  CloseAccess(SoakPlan& plan, std::uint64_t seed)
      : plan_(plan), random_(seed ^ kCloseChance), rates_(seed ^ kRatesChance) {}

  void draw() {
    if (is_guarded(plan_) || !random_.chance(400)) {
      return;
    }
    draw_roles();
    std::vector<SpokenRule> rules;
    // Those who look at the end how the gateway is.
    rules.push_back({.writes = false, .groups = {{.hosts = {0}}}, .functions = {0x03, 0x04}});
    deny_units(rules);
    for (unsigned count = random_.between(1U, 4U); count > 0; --count) {
      rules.push_back(draw_rule());
      if (rules.back().permits && random_.chance(600)) {
        rules.push_back(opposite(rules.back()));
      }
    }
    rules.insert(rules.end(), plan_.rules.begin(), plan_.rules.end());
    rules.push_back({.writes = random_.chance(800), .any_role = true});
    const auto before = std::exchange(plan_.rules, std::move(rules));
    draw_rates();
    if (std::ranges::none_of(plan_.clients, [&](const Manners& client) {
          return lets_in_by_rules(plan_, client.listener, client.host, client.role);
        })) {
      plan_.rules = before;  // a plant in which nobody may ask for anything shows nothing
    }
    write_rules(plan_);
  }

 private:
  void draw_roles();
  void draw_rates();
  void deny_units(std::vector<SpokenRule>& rules);
  SpokenRule draw_rule();
  std::vector<SpokenGroup> draw_groups();
  SpokenRegisters draw_registers();
  std::vector<std::string> some_roles();
  std::vector<std::size_t> some_of(std::size_t count, unsigned permille);
  // What is permitted to some only.
  SpokenRule opposite(const SpokenRule& rule) {
    return {.permits = false,
            .reads = rule.reads && random_.chance(300),
            .any_role = random_.chance(700),
            .devices = rule.devices,
            .registers = rule.registers};
  }

  SoakPlan& plan_;
  Random random_;
  Random rates_;  // and what is said of units
};

void CloseAccess::draw_roles() {
  const std::size_t listeners = plan_.settings.listeners.size();
  plan_.settings.tls.push_back({.name = "plant"});
  for (const std::size_t listener : some_of(listeners, 350)) {
    give_roles(plan_, listener, 30, random_);
  }
}

std::vector<std::size_t> CloseAccess::some_of(std::size_t count, unsigned permille) {
  std::vector<std::size_t> some;
  for (std::size_t place = 0; place < count; ++place) {
    if (random_.chance(permille)) {
      some.push_back(place);
    }
  }
  return some;
}

std::vector<std::string> CloseAccess::some_roles() {
  return random_.one_of<std::vector<std::string>>(
      {{"operator"}, {"viewer"}, {""}, {"operator", "viewer"}, {"operator", ""}});
}

// One host may be in several.
std::vector<SpokenGroup> CloseAccess::draw_groups() {
  std::vector<SpokenGroup> groups;
  for (unsigned count = random_.between(1U, 3U); count > 0; --count) {
    SpokenGroup group{.hosts = draw_hosts(random_, random_.one_of({0U, 300U, 700U}))};
    if (group.hosts.empty() || random_.chance(500)) {
      group.roles = some_roles();
    }
    groups.push_back(std::move(group));
  }
  return groups;
}

SpokenRegisters CloseAccess::draw_registers() {
  SpokenRegisters registers;
  registers.motion = random_.chance(250);
  registers.communication = random_.chance(150);
  registers.values = random_.chance(250);
  registers.stops = random_.chance(200);
  for (unsigned count = random_.between(registers.are_any() ? 0U : 1U, 2U); count > 0; --count) {
    const auto table = random_.one_of({Table::holding_registers, Table::holding_registers,
                                       Table::holding_registers, Table::input_registers,
                                       Table::coils, Table::discrete_inputs});
    SpokenSpan span{.table = table};
    if (!random_.chance(150)) {
      const unsigned end = table == Table::coils ? kCoils : kRegisters;
      span.first = random_.below(unsigned{end});
      span.last = span.first + random_.below(end - span.first);
    }
    registers.spans.push_back(span);
  }
  return registers;
}

SpokenRule CloseAccess::draw_rule() {
  SpokenRule rule{.permits = random_.chance(400)};
  rule.reads = random_.chance(600);
  rule.writes = !rule.reads || random_.chance(600);
  if (random_.chance(600)) {
    rule.devices = some_of(plan_.settings.devices.size(), 400);
  }
  if (random_.chance(500)) {
    rule.registers = draw_registers();
  }
  if (random_.chance(450)) {
    rule.groups = draw_groups();
  }
  if (random_.chance(200)) {
    rule.roles = some_roles();
  }
  rule.any_role = random_.chance(400);
  if (random_.chance(250)) {
    rule.listeners = some_of(plan_.settings.listeners.size(), 400);
  }
  if (random_.chance(150)) {
    rule.functions = random_.one_of<std::vector<std::uint8_t>>(
        {{0x03, 0x10}, {0x06, 0x10, kBothAtOnce}, {0x01, 0x02, 0x04, 0x0F}});
  }
  if (rule.permits && random_.chance(150)) {
    rule.units = draw_units(plan_, random_);
  }
  const bool is_for_all = rule.devices.empty() && !rule.registers.are_any() &&
                          rule.groups.empty() && rule.listeners.empty();
  if (is_for_all && !rule.permits) {
    rule.devices = {random_.below(plan_.settings.devices.size())};
  }
  return rule;
}

// What is written through them, and so to all on their lines.
void CloseAccess::deny_units(std::vector<SpokenRule>& rules) {
  auto units = draw_units(plan_, rates_);
  if (!units.empty() && rates_.chance(600)) {
    rules.push_back({.permits = false,
                     .reads = rates_.chance(300),
                     .groups = {{.hosts = draw_hosts(rates_, 400)}},
                     .any_role = rates_.chance(700),
                     .units = std::move(units)});
  }
}

// Not of those who look at the end how the gateway is: of the first rule.
void CloseAccess::draw_rates() {
  for (std::size_t place = 1; place < plan_.rules.size(); ++place) {
    SpokenRule& rule = plan_.rules[place];
    if (rule.permits && rates_.chance(350)) {
      rule.rate = rates_.one_of({1U, 3U, 5U, 10U, 20U, 50U});
    }
  }
}

}  // namespace

void draw_close_access(SoakPlan& plan, std::uint64_t seed) { CloseAccess(plan, seed).draw(); }

// Whose role cannot be read may do nothing, also where there is no rule at all.
void draw_roles_alone(SoakPlan& plan, std::uint64_t seed) {
  Random random(seed ^ kAloneChance);
  if (is_guarded(plan) || plan.theme != Theme::none || !plan.rules.empty() ||
      !plan.settings.tls.empty() || !random.chance(200)) {
    return;
  }
  plan.settings.tls.push_back({.name = "plant"});
  for (std::size_t listener = 0; listener < plan.settings.listeners.size(); ++listener) {
    if (random.chance(500)) {
      give_roles(plan, listener, 400, random);
    }
  }
  for (Manners& manners : plan.clients) {
    const bool has_role = manners.role.kind != routing::ClientRole::Kind::none;
    manners.asks_gateway = has_role ? random.one_of({50U, 200U}) : 0U;
  }
}

}  // namespace mbgate::soak
