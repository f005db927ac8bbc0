// SPDX-License-Identifier: Apache-2.0
// What the access rules deny (docs/access-rules.md).
#include <algorithm>

#include "soak/access.hpp"
#include "soak/asked.hpp"
#include "soak/touched.hpp"

namespace mbgate::soak {
namespace {

using RoleKind = routing::ClientRole::Kind;

constexpr std::uint8_t kDenied = 1;

template <typename Thing, typename Other>
bool is_among(const std::vector<Thing>& named, const Other& it) {
  return std::ranges::find(named, it) != named.end();
}

template <typename Thing, typename Other>
bool is_named(const std::vector<Thing>& named, const Other& it) {
  return named.empty() || is_among(named, it);
}

class RuleJudge {
 public:
  RuleJudge(const SoakPlan& plan, std::size_t listener, const Asked& asked)
      : plan_(plan), asked_(asked), listener_(listener) {}

  // The rules that decide on each half, by their place; one that denies it, or none.
  struct Verdict {
    bool permitted = true;
    std::vector<std::size_t> rules{};
  };
  [[nodiscard]] Verdict verdict() const;

 private:
  using Registers = SpokenRegisters;
  [[nodiscard]] bool fits(const SpokenRule& rule, const Half& half) const;
  [[nodiscard]] bool fits_role(const SpokenRule& rule, const SpokenGroup& group) const;
  [[nodiscard]] bool fits_client(const SpokenRule& rule) const;
  [[nodiscard]] bool fits_unit(const SpokenRule& rule, const Half& half) const;
  [[nodiscard]] bool goes_there_too(std::uint8_t unit) const;
  [[nodiscard]] bool fits_touched(const SpokenRule& rule, const Half& half) const;
  [[nodiscard]] bool fits_one(const SpokenRule& rule, const Touched& touched) const;
  [[nodiscard]] Table table_in(const Touched& touched, Table table) const;
  [[nodiscard]] bool has(const Registers& registers, const Touched& touched, unsigned at) const;

  const SoakPlan& plan_;
  const Asked& asked_;
  std::size_t listener_;
};

RuleJudge::Verdict RuleJudge::verdict() const {
  if (plan_.rules.empty() || asked_.role.kind == RoleKind::unreadable) {
    return {.permitted = plan_.rules.empty() && asked_.role.kind != RoleKind::unreadable};
  }
  Verdict verdict;
  for (const Half& half : halves_of(plan_, asked_)) {
    const auto decides = std::ranges::find_if(plan_.rules, [&](const SpokenRule& rule) {
      return is_written(plan_, rule) && fits(rule, half);
    });
    if (decides == plan_.rules.end() || !decides->permits) {
      return {.permitted = false};
    }
    const auto place = static_cast<std::size_t>(decides - plan_.rules.begin());
    if (!is_among(verdict.rules, place)) {
      verdict.rules.push_back(place);
    }
  }
  return verdict;
}

bool RuleJudge::fits(const SpokenRule& rule, const Half& half) const {
  return (half.reads ? rule.reads : rule.writes) && fits_unit(rule, half) &&
         is_named(rule.functions, asked_.pdu.front()) && is_named(rule.listeners, listener_) &&
         fits_client(rule) && fits_touched(rule, half);
}

// What is for all is for each unit that leads there, if a rule denies.
bool RuleJudge::fits_unit(const SpokenRule& rule, const Half& half) const {
  const bool is_for_all = half.is_known && asked_.door != nullptr && !asked_.door->device;
  return is_named(rule.units, asked_.unit) ||
         (!rule.permits && is_for_all &&
          std::ranges::any_of(rule.units, [&](std::uint8_t it) { return goes_there_too(it); }));
}

// Does the unit lead to a bus that the request goes out on?
bool RuleJudge::goes_there_too(std::uint8_t unit) const {
  const auto goes_to = [&](gateway::BusId bus) {
    return std::ranges::find(asked_.pieces, static_cast<std::size_t>(bus), &Piece::bus) !=
           asked_.pieces.end();
  };
  if (const auto& bus = plan_.settings.listeners[listener_].bus) {
    return goes_to(*bus);
  }
  const auto leads = [&](std::size_t place, bool is_own) {
    const routing::Route& route = plan_.settings.routes[place];
    const bool is_there =
        !plan_.absent.routes[place] && !(route.device && plan_.absent.devices[*route.device]);
    return is_there && route.first_unit <= unit && unit <= route.last_unit &&
           route.listener.has_value() == is_own &&
           (!is_own || static_cast<std::size_t>(*route.listener) == listener_);
  };
  for (const bool is_own : {true, false}) {
    for (std::size_t place = 0; place < plan_.settings.routes.size(); ++place) {
      if (leads(place, is_own)) {
        return std::ranges::any_of(plan_.settings.routes[place].buses, goes_to);
      }
    }
  }
  return false;
}

// Who has a role is meant only where roles are named, or any; who has none where none are.
bool RuleJudge::fits_role(const SpokenRule& rule, const SpokenGroup& group) const {
  const bool are_named = !rule.roles.empty() || !group.roles.empty();
  if (asked_.role.kind == RoleKind::none) {
    return !are_named;
  }
  return (are_named || rule.any_role) && is_named(rule.roles, asked_.role.name) &&
         is_named(group.roles, asked_.role.name);
}

bool RuleJudge::fits_client(const SpokenRule& rule) const {
  if (rule.groups.empty()) {
    return fits_role(rule, {});
  }
  return std::ranges::any_of(rule.groups, [&](const SpokenGroup& group) {
    return is_named(group.hosts, asked_.host) && fits_role(rule, group);
  });
}

// One that permits must name all of it, one that denies any of it. Of what cannot be carried out
// anyway it is not known: what may permit it does, and what may deny it does not.
bool RuleJudge::fits_touched(const SpokenRule& rule, const Half& half) const {
  if (rule.devices.empty() && !rule.registers.are_any()) {
    return true;
  }
  if (!half.is_known) {
    return rule.permits;
  }
  const auto fits_it = [&](const Touched& touched) { return fits_one(rule, touched); };
  return rule.permits ? std::ranges::all_of(half.touched, fits_it)
                      : std::ranges::any_of(half.touched, fits_it);
}

bool RuleJudge::fits_one(const SpokenRule& rule, const Touched& touched) const {
  if (!rule.devices.empty() && (!touched.device || !is_among(rule.devices, *touched.device))) {
    return false;
  }
  if (!rule.registers.are_any()) {
    return true;
  }
  if (!touched.range) {
    return false;
  }
  const bool names_stops = rule.registers.stops;
  // To permit stops permits the register that stops, and not its parameters.
  unsigned at = touched.range->first;
  const unsigned end = at + touched.range->count;
  at += rule.permits && names_stops && touched.stop == StopAmong::alone ? 1U : 0U;
  unsigned named = 0;
  for (unsigned each = at; each < end; ++each) {
    named += has(rule.registers, touched, each) ? 1U : 0U;
  }
  return rule.permits ? named == end - at
                      : named > 0 || (names_stops && touched.stop != StopAmong::none);
}

// A drive may show the same registers as both.
Table RuleJudge::table_in(const Touched& touched, Table table) const {
  const bool are_one =
      touched.device && plan_.settings.devices[*touched.device].profile.input_as_holding;
  return are_one && table == Table::input_registers ? Table::holding_registers : table;
}

bool RuleJudge::has(const Registers& registers, const Touched& touched, unsigned at) const {
  const Table table = table_in(touched, touched.range->table);
  const auto is_in_it = [&](const SpokenSpan& span) {
    return table_in(touched, span.table) == table && span.first <= at && at <= span.last;
  };
  if (std::ranges::any_of(registers.spans, is_in_it)) {
    return true;
  }
  if (!touched.device) {
    return false;
  }
  const bool is_holding = table == Table::holding_registers;
  const bool is_opcode = is_holding && at >= kOpcodeRegister && at <= kOpcodeRegister + 2U;
  const bool may_stop =
      (is_holding && at == kStopRegister) || (table == Table::coils && at == kStopCoil);
  return (registers.motion && (is_motion(table, at) || is_opcode || may_stop)) ||
         (registers.communication && is_holding && at == kCommunicationRegister) ||
         (registers.values && is_in_value(table, at));
}

}  // namespace

bool is_written(const SoakPlan& plan, const SpokenRule& rule) {
  const auto are_any = [](const std::vector<std::size_t>& named, const std::vector<bool>& absent) {
    return named.empty() ||
           std::ranges::any_of(named, [&](std::size_t place) { return !absent[place]; });
  };
  return are_any(rule.devices, plan.absent.devices) &&
         are_any(rule.listeners, plan.absent.listeners);
}

bool lets_in_by_rules(const SoakPlan& plan, std::size_t listener, unsigned host,
                      const routing::ClientRole& role) {
  const bool has_role = role.kind != RoleKind::none;
  const auto may_mean = [&](const SpokenRule& rule, const SpokenGroup& group) {
    const bool are_named = !rule.roles.empty() || !group.roles.empty();
    return is_named(group.hosts, host) && (has_role ? are_named || rule.any_role : !are_named);
  };
  for (const SpokenRule& rule : plan.rules) {
    const bool is_meant = rule.groups.empty()
                              ? may_mean(rule, {})
                              : std::ranges::any_of(rule.groups, [&](const SpokenGroup& group) {
                                  return may_mean(rule, group);
                                });
    if (!is_written(plan, rule) || !is_named(rule.listeners, listener) || !is_meant) {
      continue;
    }
    const bool is_for_all = rule.reads && rule.writes && !has_role && rule.units.empty() &&
                            rule.functions.empty() && rule.devices.empty() &&
                            !rule.registers.are_any();
    if (rule.permits || is_for_all) {
      return rule.permits;
    }
  }
  return plan.rules.empty();
}

// What may permit it does, as long as not all is known of what is written.
bool lets_write_by_rules(const SoakPlan& plan, std::size_t listener, unsigned host,
                         std::size_t device) {
  for (const SpokenRule& rule : plan.rules) {
    const bool is_host_named = std::ranges::any_of(
        rule.groups, [&](const SpokenGroup& group) { return is_named(group.hosts, host); });
    if (!is_written(plan, rule) || !rule.writes || !is_named(rule.listeners, listener) ||
        !is_named(rule.devices, device) || !(rule.groups.empty() || is_host_named)) {
      continue;
    }
    const bool is_for_all =
        rule.units.empty() && rule.functions.empty() && !rule.registers.are_any();
    if (rule.permits || is_for_all) {
      return rule.permits;
    }
  }
  return plan.rules.empty();
}

void deny_by_rules(const SoakPlan& plan, std::size_t listener, Asked& asked) {
  const auto verdict = RuleJudge(plan, listener, asked).verdict();
  const bool any_answer = asked.any_code && asked.role.kind != RoleKind::unreadable;
  if (verdict.permitted || any_answer) {
    for (std::size_t rule = 0; rule < plan.rules.size(); ++rule) {
      if (plan.rules[rule].rate > 0 && (any_answer || is_among(verdict.rules, rule))) {
        asked.rated.push_back(rule);
      }
    }
    return;
  }
  asked.refused = kDenied;
  asked.stops_all = false;  // what it would have stopped goes on
  asked.kind = asked.kind == Kind::stop ? Kind::write : asked.kind;
}

}  // namespace mbgate::soak
