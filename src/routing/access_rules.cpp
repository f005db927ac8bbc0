// SPDX-License-Identifier: Apache-2.0
#include "routing/access_rules.hpp"

#include <algorithm>
#include <functional>

namespace mbgate::routing {
namespace {

using Roles = std::vector<std::string>;

// In this order, so that the least of all conditions is that of the rule.
enum class Fit : std::uint8_t { no, maybe, yes };

Fit fit_if(bool fits) { return fits ? Fit::yes : Fit::no; }

bool names(const auto& list, const auto& it) { return std::ranges::find(list, it) != list.end(); }

// Whose role is named fits only where roles are named, in the rule or in its group; without a
// certificate nobody has a role.
Fit fit_role(const AccessRule& rule, const Roles& of_group, const ClientRole* role) {
  const bool named = !rule.roles.empty() || !of_group.empty();
  if (role == nullptr) {
    return named || rule.any_role ? Fit::maybe : Fit::no;
  }
  switch (role->kind) {
    case ClientRole::Kind::none: return fit_if(!named);
    case ClientRole::Kind::unreadable: return Fit::no;
    case ClientRole::Kind::named: break;
  }
  return fit_if((named || rule.any_role) && (rule.roles.empty() || names(rule.roles, role->name)) &&
                (of_group.empty() || names(of_group, role->name)));
}

Fit fit_client(const AccessRule& rule, const AccessQuestion& question) {
  if (rule.clients.empty()) {
    return fit_role(rule, {}, question.role);
  }
  Fit best = Fit::no;
  for (const ClientGroup& group : rule.clients) {
    if (group.addresses.empty() || contains(group.addresses, question.address)) {
      best = std::max(best, fit_role(rule, group.roles, question.role));
    }
  }
  return best;
}

Fit fit_listener(const AccessRule& rule, const AccessQuestion& question) {
  return fit_if(rule.listeners.empty() || names(rule.listeners, question.listener));
}

Fit fit_unit(const AccessRule& rule, const AccessQuestion& question) {
  if (!rule.units) {
    return Fit::yes;
  }
  if (!question.unit) {
    return Fit::maybe;
  }
  return fit_if(rule.permits ? rule.units->test(*question.unit)
                             : (*rule.units & question.reached).any());
}

Fit fit_function(const AccessRule& rule, const AccessQuestion& question) {
  if (!rule.functions) {
    return Fit::yes;
  }
  return question.function ? fit_if(*question.function < rule.functions->size() &&
                                    rule.functions->test(*question.function))
                           : Fit::maybe;
}

Fit fit_access(const AccessRule& rule, const AccessQuestion& question) {
  if (rule.access == RuleAccess::both) {
    return Fit::yes;
  }
  return question.is_read ? fit_if(*question.is_read == (rule.access == RuleAccess::read))
                          : Fit::maybe;
}

// The name "stops" stands for values that stop, without the parameters written behind them.
Fit fit_registers(const AccessRule& rule, const TouchedRegisters& touched) {
  const RegisterSet& registers = rule.registers;
  if (registers.empty()) {
    return Fit::yes;
  }
  if (!touched.range) {
    return Fit::no;
  }
  if (rule.permits) {
    return fit_if((registers.stops && touched.stop == StopIn::all) || registers.covers(touched));
  }
  return fit_if((registers.stops && touched.stop != StopIn::none) || registers.touches(touched));
}

Fit fit_touched(const AccessRule& rule, const TouchedRegisters& touched) {
  const bool of_device =
      rule.devices.empty() || (touched.number && names(rule.devices, *touched.number));
  return of_device ? fit_registers(rule, touched) : Fit::no;
}

Fit fit_target(const AccessRule& rule, const AccessQuestion& question) {
  if (rule.devices.empty() && rule.registers.empty()) {
    return Fit::yes;
  }
  if (!question.touched) {
    return Fit::maybe;
  }
  if (question.touched->empty()) {
    return Fit::no;
  }
  Fit all = Fit::yes;
  Fit any = Fit::no;
  for (const TouchedRegisters& touched : *question.touched) {
    const Fit fit = fit_touched(rule, touched);
    all = std::min(all, fit);
    any = std::max(any, fit);
  }
  return rule.permits ? all : any;
}

Fit fit_of(const AccessRule& rule, const AccessQuestion& question) {
  Fit least = Fit::yes;
  for (const auto condition :
       {fit_listener, fit_client, fit_unit, fit_function, fit_access, fit_target}) {
    if (least != Fit::no) {
      least = std::min(least, condition(rule, question));
    }
  }
  return least;
}

// Has `wide` everything of `narrow`, where an empty list means everything?
template <typename List, typename Has = std::ranges::equal_to>
bool has_all(const List& wide, const List& narrow, Has has = {}) {
  return wide.empty() || (!narrow.empty() && std::ranges::all_of(narrow, [&](const auto& it) {
           return std::ranges::any_of(wide, [&](const auto& other) { return has(other, it); });
         }));
}

template <typename Set>
bool has_all_of_set(const std::optional<Set>& wide, const std::optional<Set>& narrow) {
  return !wide || (narrow && (*narrow & ~*wide).none());
}

// Are the roles that the list lets through among these? Empty lists let all through.
bool lets_through(const Roles& wide, const Roles& rule, const Roles& group) {
  return wide.empty() || has_all(wide, rule) || has_all(wide, group);
}

bool hides_roles(const AccessRule& earlier, const ClientGroup& wide, const AccessRule& later,
                 const ClientGroup& narrow) {
  const bool earlier_named = !earlier.roles.empty() || !wide.roles.empty();
  const bool later_named = !later.roles.empty() || !narrow.roles.empty();
  if (!lets_through(earlier.roles, later.roles, narrow.roles) ||
      !lets_through(wide.roles, later.roles, narrow.roles)) {
    return false;
  }
  if (later_named) {
    return earlier_named || earlier.any_role;
  }
  return !earlier_named && (earlier.any_role || !later.any_role);
}

bool hides_clients(const AccessRule& earlier, const AccessRule& later) {
  const std::vector<ClientGroup> everyone(1);
  const auto& wide = earlier.clients.empty() ? everyone : earlier.clients;
  const auto& narrow = later.clients.empty() ? everyone : later.clients;
  const auto has = [](const Network& one, const Network& other) { return one.contains(other); };
  return std::ranges::all_of(narrow, [&](const ClientGroup& group) {
    return std::ranges::any_of(wide, [&](const ClientGroup& it) {
      return has_all(it.addresses, group.addresses, has) && hides_roles(earlier, it, later, group);
    });
  });
}

// Of what a later rule fits the earlier one must fit everything, if it permits, or anything: one
// that denies also matches by the units that a broadcast is for.
bool hides_target(const AccessRule& earlier, const AccessRule& later) {
  const bool is_narrow = earlier.units || !earlier.devices.empty() || !earlier.registers.empty();
  return (!is_narrow || !earlier.permits || later.permits) &&
         has_all_of_set(earlier.units, later.units) && has_all(earlier.devices, later.devices) &&
         (earlier.registers.empty() ||
          (!later.registers.empty() && earlier.registers.contains(later.registers)));
}

}  // namespace

std::string AccessRule::title() const {
  return name.empty() ? place : '"' + name + "\" (" + place + ")";
}

AccessDecision decide(std::span<const AccessRule> rules, const AccessQuestion& question) {
  for (const AccessRule& rule : rules) {
    const Fit fit = fit_of(rule, question);
    if (fit == Fit::yes || (fit == Fit::maybe && rule.permits)) {
      return {rule.permits, &rule};
    }
  }
  return {rules.empty(), nullptr};
}

bool hides(const AccessRule& earlier, const AccessRule& later) {
  return hides_clients(earlier, later) && has_all(earlier.listeners, later.listeners) &&
         has_all_of_set(earlier.functions, later.functions) &&
         (earlier.access == RuleAccess::both || earlier.access == later.access) &&
         hides_target(earlier, later);
}

}  // namespace mbgate::routing
