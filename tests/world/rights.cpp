// SPDX-License-Identifier: Apache-2.0
#include "world/rights.hpp"

#include <algorithm>

namespace mbgate::world {
namespace {

constexpr std::uint64_t kRightsChance = 0x524947485453ULL;
constexpr unsigned kLastRegister = kTableEnd - 1;

template <typename Thing>
bool names(const std::vector<Thing>& named, const Thing& it) {
  return named.empty() || std::ranges::count(named, it) > 0;
}

// Of a request, either what it reads or what it writes.
struct Half {
  bool reads = false;
  std::vector<Cell> cells{};  ///< none: it names no register
  bool stops = false;
};

std::vector<Half> halves_of(const Intent& intent) {
  std::vector<Half> halves;
  if (intent.kind == Kind::read || intent.reads) {
    Half& half = halves.emplace_back(Half{true, {}, false});
    for (unsigned at = 0; intent.reads && at < intent.reads->count; ++at) {
      half.cells.push_back({intent.reads->table, intent.reads->first + at, 0});
    }
  }
  if (intent.kind != Kind::read) {
    Half& half = halves.emplace_back();
    for (Cell cell : intent.writes) {
      cell.place -= cell.place >= kMasks && cell.place < kOpaque ? kMasks : 0;
      if (cell.place < kTableEnd) {
        half.cells.push_back(cell);
      }
      half.stops = half.stops || (cell.table == Table::holding_registers &&
                                  (cell.place == kStopRegister || cell.place == kOtherStop));
    }
  }
  return halves;
}

bool has_registers(const RulePlan& rule) {
  return !rule.spans.empty() || rule.stops || rule.communication;
}

bool has(const RulePlan& rule, const Cell& cell) {
  const bool is_communication =
      cell.table == Table::holding_registers && cell.place == kCommunicationRegister;
  return (rule.communication && is_communication) ||
         std::ranges::any_of(rule.spans, [&](const Range& span) {
           return span.table == cell.table && span.first <= cell.place &&
                  cell.place < span.first + span.count;
         });
}

// One that permits must name all that is touched, one that denies any of it.
bool fits_registers(const RulePlan& rule, const Half& half) {
  if (!has_registers(rule)) {
    return true;
  }
  if (half.cells.empty()) {
    return false;
  }
  if (rule.stops && half.stops) {
    return true;  // the world's stops write nothing else
  }
  const auto is_named = [&](const Cell& cell) { return has(rule, cell); };
  return rule.permits ? std::ranges::all_of(half.cells, is_named)
                      : std::ranges::any_of(half.cells, is_named);
}

// Register addresses are a matter of 16 bits in the settings.
void write_rules(Plan& plan) {
  plan.settings.rules.clear();
  for (const RulePlan& spoken : plan.rules) {
    routing::AccessRule& rule = plan.settings.rules.emplace_back();
    rule.permits = spoken.permits;
    rule.access = spoken.reads == spoken.writes ? routing::RuleAccess::both
                  : spoken.reads                ? routing::RuleAccess::read
                                                : routing::RuleAccess::write;
    if (!spoken.hosts.empty()) {
      rule.clients.push_back({"group", networks_of(spoken.hosts), {}});
    }
    for (const std::size_t listener : spoken.listeners) {
      rule.listeners.push_back(routing::ListenerId{static_cast<std::uint32_t>(listener)});
    }
    for (const std::size_t station : spoken.stations) {
      rule.devices.push_back(*plan.stations[station].device);
    }
    for (const std::uint8_t unit : spoken.units) {
      rule.units = rule.units.value_or(routing::UnitSet{}).set(unit);
    }
    for (const std::uint8_t function : spoken.functions) {
      rule.functions = rule.functions.value_or(routing::FunctionSet{}).set(function);
    }
    for (const Range& span : spoken.spans) {
      const unsigned last = std::min(span.first + span.count - 1, kLastRegister);
      rule.registers.spans.push_back(
          {span.table, static_cast<std::uint16_t>(span.first), static_cast<std::uint16_t>(last)});
    }
    rule.registers.stops = spoken.stops;
    rule.registers.communication_registers = spoken.communication;
    rule.per_second = spoken.rate;
  }
}

// The last host of all is nobody's in particular: it asks when all is over whether drives are back.
std::vector<unsigned> some_hosts(Random& random, unsigned permille) {
  std::vector<unsigned> hosts;
  for (unsigned host = 0; host + 1 < kMostHosts; ++host) {
    if (random.chance(permille)) {
      hosts.push_back(host);
    }
  }
  return hosts.empty() ? std::vector<unsigned>{0} : hosts;
}

// No span cuts a value: what is read beyond a request's own registers changes nothing.
RulePlan draw_rule(const Plan& plan, Random& random) {
  RulePlan rule;
  rule.hosts = some_hosts(random, random.one_of({200U, 500U, 900U}));
  rule.permits = random.chance(250);
  switch (random.between(0U, 6U)) {
    case 0: rule.reads = false; break;
    case 1:
      rule.functions =
          random.one_of<std::vector<std::uint8_t>>({{0x16}, {0x17}, {5, 15}, {8, 0x41}, {1, 2, 4}});
      break;
    case 2:
      rule.spans = {random.one_of<Range>({{Table::holding_registers, 0, kLiveFrom},
                                          {Table::holding_registers, kPairsFrom, 20},
                                          {Table::input_registers, 0, kTableEnd},
                                          {Table::coils, 0, kCoils / 2}})};
      rule.reads = random.chance(700);
      rule.writes = !rule.reads || random.chance(500);
      break;
    case 3:
      rule.stops = true;
      rule.reads = false;
      break;
    case 4: rule.stations = {random.below(plan.stations.size())}; break;
    case 5: rule.units = {plan.doors[random.below(plan.doors.size())].unit}; break;
    default:
      rule.communication = true;
      rule.reads = false;
      break;
  }
  if (random.chance(300)) {
    rule.listeners = {random.below(plan.settings.listeners.size())};
  }
  if (rule.permits && random.chance(500)) {
    rule.rate = random.one_of({3U, 10U, 40U});
  }
  return rule;
}

void draw_rules(Plan& plan, Random& random) {
  for (unsigned count = random.between(0U, 3U); count > 0; --count) {
    plan.rules.push_back(draw_rule(plan, random));
  }
  RulePlan last;
  if (random.chance(500)) {
    RulePlan writers;
    writers.reads = false;
    writers.hosts = some_hosts(random, 600);
    writers.rate = random.one_of({0U, 0U, 5U, 20U});
    plan.rules.push_back(writers);
    last.writes = false;
  } else if (random.chance(300)) {
    RulePlan rated;
    rated.hosts = some_hosts(random, 500);
    rated.rate = random.one_of({5U, 20U, 50U});
    plan.rules.push_back(rated);
  }
  plan.rules.push_back(last);
}

void name_functions(Plan& plan, Random& random) {
  for (std::size_t at = 0; at < plan.settings.routes.size(); ++at) {
    routing::Route& route = plan.settings.routes[at];
    if (!route.device || !route.windows.empty() || !random.chance(150)) {
      continue;
    }
    std::bitset<128> named = routing::FunctionRules::rewritable().allowed;
    named.reset(random.one_of<std::size_t>({1, 4, 5, 6, 15, 16, 22, 23}));
    named.set(8, random.chance(500));
    named.set(0x11, random.chance(500));
    route.functions.allowed = named;
    route.functions_named = true;
    for (Door& door : plan.doors) {
      if (door.route == at) {
        door.functions = named;
      }
    }
  }
}

}  // namespace

Verdict verdict_of(const Plan& plan, const Intent& intent, std::size_t listener, unsigned host) {
  Verdict verdict;
  for (const Half& half : halves_of(intent)) {
    bool permitted = plan.rules.empty();
    for (std::size_t at = 0; at < plan.rules.size(); ++at) {
      const RulePlan& rule = plan.rules[at];
      if (!(half.reads ? rule.reads : rule.writes) || !names(rule.hosts, host) ||
          !names(rule.listeners, listener) || !names(rule.functions, intent.pdu[0])) {
        continue;
      }
      const bool is_particular =
          has_registers(rule) || !rule.stations.empty() || !rule.units.empty();
      if (!intent.station && is_particular) {
        return {true, false, {}};  // it is for many drives and units
      }
      if (!names(rule.units, intent.unit) ||
          (intent.station && !names(rule.stations, *intent.station)) ||
          !fits_registers(rule, half)) {
        continue;
      }
      permitted = rule.permits;
      if (permitted && rule.rate > 0 && std::ranges::count(verdict.rated, at) == 0) {
        verdict.rated.push_back(at);
      }
      break;
    }
    if (!permitted) {
      return {false, true, {}};
    }
  }
  return verdict;
}

void draw_rights(Plan& plan) {
  Random random(plan.seed ^ kRightsChance);
  plan.writers.resize(plan.settings.devices.size());
  if (random.chance(350)) {
    draw_rules(plan, random);
    write_rules(plan);
  }
  name_functions(plan, random);
  for (auto& listener : plan.settings.listeners) {
    if (plan.reloads_every == Duration{0} && random.chance(120)) {
      listener.max_requests_per_second = random.one_of({4U, 10U});
    }
  }
  for (std::size_t at = 0; at < plan.settings.devices.size(); ++at) {
    gateway::DeviceGuard& guard = plan.settings.guards[at];
    if (guard.writer == gateway::WriterRule::any && random.chance(120)) {
      guard.writer = gateway::WriterRule::listed;
      plan.writers[at] = some_hosts(random, 500);
      guard.writers = networks_of(plan.writers[at]);
    }
  }
  plan.takes_rights = random.chance(500) ? 3 : 0;
}

const char* take_right(Plan& plan, Random& random) {
  const auto host = static_cast<unsigned>(random.below(kMostHosts - 1));
  switch (random.between(0U, 2U)) {
    case 0: {
      const std::size_t at = random.below(plan.settings.listeners.size());
      plan.readers[at].push_back(host);
      plan.settings.listeners[at].read_only = networks_of(plan.readers[at]);
      return "reader_made";
    }
    case 1: {
      const std::size_t at = random.below(plan.settings.routes.size());
      plan.settings.routes[at].access = routing::Access::read_only;
      for (Door& door : plan.doors) {
        door.read_only = door.read_only || door.route == at;
      }
      return "route_made_read_only";
    }
    default:
      if (plan.rules.empty()) {
        plan.rules.emplace_back();
      }
      RulePlan rule;
      rule.permits = rule.reads = false;
      rule.hosts = some_hosts(random, 500);
      plan.rules.insert(plan.rules.begin(), rule);
      write_rules(plan);
      return "rule_made";
  }
}

}  // namespace mbgate::world
