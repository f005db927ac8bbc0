// SPDX-License-Identifier: Apache-2.0
#include "soak/access.hpp"

#include <algorithm>
#include <utility>

#include "soak/asked.hpp"
#include "soak/hosts.hpp"
#include "soak/plan.hpp"
#include "soak/registers.hpp"

namespace mbgate::soak {
namespace {

constexpr std::uint64_t kAccessChance = 0x414343455353ULL;
constexpr std::uint8_t kReadWrite = 0x17;
constexpr std::uint8_t kDenied = 1;
constexpr std::uint8_t kNotNow = 6;

template <typename Thing>
bool is_named(const std::vector<Thing>& named, unsigned it) {
  return named.empty() || std::ranges::find(named, it) != named.end();
}

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

routing::AccessRule written_rule(const SpokenRule& spoken) {
  routing::AccessRule rule;
  rule.permits = spoken.permits;
  rule.access = spoken.reads == spoken.writes ? routing::RuleAccess::both
                : spoken.reads                ? routing::RuleAccess::read
                                              : routing::RuleAccess::write;
  if (!spoken.hosts.empty()) {
    rule.clients.push_back({"hosts", networks_of(spoken.hosts), {}});
  }
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
  return rule;
}

bool is_denied(const SoakPlan& plan, const Asked& asked, bool reads) {
  const auto decides = std::ranges::find_if(plan.rules, [&](const SpokenRule& rule) {
    return (reads ? rule.reads : rule.writes) && is_named(rule.hosts, asked.host) &&
           is_named(rule.units, asked.unit) && is_named(rule.functions, asked.pdu.front());
  });
  return decides == plan.rules.end() || !decides->permits;
}

// What is neither is a write.
bool is_reading(const PduBytes& pdu) {
  switch (pdu.front()) {
    case 0x01:
    case 0x02:
    case 0x03:
    case 0x04:
    case 0x07:
    case 0x0B:
    case 0x0C:
    case 0x11:
    case 0x14:
    case 0x18: return true;
    case 0x2B: return pdu.size() > 1 && pdu[1] == 0x0E;
    default: return false;
  }
}

}  // namespace

void draw_access(SoakPlan& plan, std::uint64_t seed) {
  Random random(seed ^ kAccessChance);
  const bool is_guarded =
      std::ranges::any_of(plan.failsafe, [](const auto& it) { return !it.empty(); });
  if (is_guarded || !random.chance(300)) {
    return;
  }
  if (random.chance(500)) {
    plan.rules.push_back({.permits = false,
                          .hosts = draw_hosts(random, 300),
                          .functions = random.one_of<std::vector<std::uint8_t>>(
                              {{0x16}, {kReadWrite}, {0x2B, kOwnFunction}, {0x07, 0x08, 0x11}})});
  }
  // A rule that is about units names only what is never asked of all at once.
  auto units = draw_units(plan, random);
  if (!units.empty() && random.chance(600)) {
    plan.rules.push_back({.permits = false,
                          .writes = false,
                          .hosts = draw_hosts(random, 400),
                          .units = std::move(units),
                          .functions = random.one_of<std::vector<std::uint8_t>>(
                              {{0x01}, {0x02, 0x04}, {0x01, 0x02, 0x04}})});
  }
  if (random.chance(300)) {
    plan.rules.push_back({.permits = false,
                          .writes = false,
                          .hosts = draw_hosts(random, 500),
                          .functions = {kReadWrite}});
  }
  const auto others = draw_hosts(random, 300);
  if (!others.empty() && random.chance(500)) {
    plan.rules.push_back({.permits = false, .reads = false, .hosts = others});
  }
  if (random.chance(300)) {
    plan.rules.push_back({.reads = false,
                          .hosts = draw_hosts(random, 600),
                          .functions = {0x05, 0x06, 0x0F, 0x10, kReadWrite}});
    plan.rules.push_back({.writes = false});
  } else {
    plan.rules.push_back({});
  }
  for (const SpokenRule& rule : plan.rules) {
    plan.settings.rules.push_back(written_rule(rule));
  }
}

void deny_by_rules(const SoakPlan& plan, Asked& asked) {
  if (plan.rules.empty() || asked.any_code) {
    return;
  }
  // Of what could not be carried out anyway only its function is known.
  const bool is_understood = !asked.refused || asked.refused == kNotNow;
  const bool both = is_understood && asked.pdu.front() == kReadWrite;
  const bool reads = is_reading(asked.pdu);
  if (is_denied(plan, asked, reads) || (both && is_denied(plan, asked, true))) {
    asked.refused = kDenied;
    asked.pieces.clear();
    asked.stops_all = false;  // what it would have stopped goes on
    asked.kind = asked.kind == Kind::stop ? Kind::write : asked.kind;
  }
}

}  // namespace mbgate::soak
