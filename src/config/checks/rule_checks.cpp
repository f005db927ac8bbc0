// SPDX-License-Identifier: Apache-2.0
// Access rules that can never match, or not where they seem to: each says something that is not so.
#include <algorithm>
#include <array>

#include "config/sections/sections.hpp"

namespace mbgate::config {
namespace {

using gateway::Settings;
using modbus::Table;
using routing::AccessRule;
using routing::ListenerId;
using routing::RuleAccess;

void warn(Draft& draft, std::size_t at, std::string_view why) {
  draft.document.warning(draft.rules[at].position(),
                         "[[rule]]: can never match: " + std::string(why));
}

std::vector<ListenerId> listeners_of(const Settings& settings, const AccessRule& rule) {
  if (!rule.listeners.empty()) {
    return rule.listeners;
  }
  std::vector<ListenerId> all;
  all.reserve(settings.listeners.size());
  for (std::size_t i = 0; i < settings.listeners.size(); ++i) {
    all.push_back(ListenerId{static_cast<std::uint32_t>(i)});
  }
  return all;
}

bool have_common(const std::vector<std::string>& a, const std::vector<std::string>& b) {
  return std::ranges::find_first_of(a, b) != a.end();
}

// A client must have a role of the rule and one of its group, and it has one role.
bool have_disjoint_roles(const AccessRule& rule) {
  return !rule.roles.empty() && !rule.clients.empty() &&
         std::ranges::all_of(rule.clients, [&](const routing::ClientGroup& group) {
           return !group.roles.empty() && !have_common(group.roles, rule.roles);
         });
}

// That a rule without roles permits nothing there is safe; that it denies nothing either is what
// nobody expects.
void warn_of_undenied(Draft& draft, std::size_t at, ListenerId open) {
  draft.document.warning(
      draft.rules[at].position(),
      "[[rule]]: denies nothing on listener {}, which has 'tls', because it names no role: give "
      "'roles', any_role = true, or 'listeners' without 'tls'",
      in_quotes(draft.settings.listener(open).name));
}

void check_roles(Draft& draft, std::size_t at) {
  const AccessRule& rule = draft.settings.rules[at];
  const auto listeners = listeners_of(draft.settings, rule);
  const auto encrypts = [&](ListenerId id) { return has_tls(draft.settings.listener(id)); };
  const auto names_role = [](const routing::ClientGroup& group) { return !group.roles.empty(); };
  const auto encrypted = std::ranges::find_if(listeners, encrypts);
  const bool always_named = !rule.roles.empty() || (!rule.clients.empty() &&
                                                    std::ranges::all_of(rule.clients, names_role));
  const bool ever_named = !rule.roles.empty() || std::ranges::any_of(rule.clients, names_role);
  if (always_named && encrypted == listeners.end()) {
    warn(draft, at, "it names roles, and none of its listeners has 'tls'");
  } else if (have_disjoint_roles(rule)) {
    warn(draft, at, "its 'roles' and those of its groups have none in common");
  } else if (!ever_named && !rule.any_role && std::ranges::all_of(listeners, encrypts)) {
    warn(draft, at,
         "all its listeners have 'tls', and it names no role: give 'roles', or any_role = true");
  } else if (!ever_named && !rule.any_role && !rule.permits && encrypted != listeners.end()) {
    warn_of_undenied(draft, at, *encrypted);
  }
}

void check_addresses(Draft& draft, std::size_t at) {
  const AccessRule& rule = draft.settings.rules[at];
  const auto lets_in = [&](ListenerId id, const routing::ClientGroup& group) {
    const auto& allow = draft.settings.listener(id).allow;
    return allow.empty() || group.addresses.empty() || routing::have_common(allow, group.addresses);
  };
  const auto listeners = listeners_of(draft.settings, rule);
  const bool any =
      rule.clients.empty() || std::ranges::any_of(rule.clients, [&](const auto& group) {
        return std::ranges::any_of(listeners, [&](ListenerId id) { return lets_in(id, group); });
      });
  if (!any) {
    warn(draft, at, "'allow' of its listeners has none of its clients");
  }
}

/// 23 reads and writes; 43 reads or writes by its MEI type.
void check_functions(Draft& draft, std::size_t at) {
  constexpr std::array<std::size_t, 10> kOnlyRead{1, 2, 3, 4, 7, 11, 12, 17, 20, 24};
  constexpr std::array<std::size_t, 2> kBoth{23, 43};
  const AccessRule& rule = draft.settings.rules[at];
  if (!rule.functions || rule.access == RuleAccess::both) {
    return;
  }
  for (std::size_t function = 0; function < rule.functions->size(); ++function) {
    const bool both = std::ranges::find(kBoth, function) != kBoth.end();
    const bool reads = std::ranges::find(kOnlyRead, function) != kOnlyRead.end();
    if (rule.functions->test(function) && (both || reads == (rule.access == RuleAccess::read))) {
      return;
    }
  }
  warn(draft, at,
       rule.access == RuleAccess::read ? "none of its functions reads"
                                       : "none of its functions writes");
}

bool is_read_only(Table table) {
  return table == Table::discrete_inputs || table == Table::input_registers;
}

bool names_by_profile(const routing::RegisterSet& set) {
  return set.motion_commands || set.communication_registers || set.values || set.stops;
}

/// The devices that a rule is about; those without errors.
std::vector<const drive::Device*> devices_of(const Settings& settings, const AccessRule& rule) {
  std::vector<const drive::Device*> devices;
  for (std::size_t i = 0; i < settings.devices.size(); ++i) {
    if (rule.devices.empty() || std::ranges::find(rule.devices, i) != rule.devices.end()) {
      devices.push_back(&settings.devices[i]);
    }
  }
  return devices;
}

bool has_named(const drive::Profile& profile, const routing::RegisterSet& set) {
  const bool stops = !profile.stops.empty();
  const auto& values = profile.values.all();
  return (set.stops && stops) || (set.values && !values.empty()) ||
         (set.communication_registers &&
          !(profile.communication.empty() && profile.guarded.empty())) ||
         (set.motion_commands &&
          (stops || profile.position_opcodes ||
           std::ranges::any_of(values, [](const drive::Value& it) { return it.motion; })));
}

void check_registers(Draft& draft, std::size_t at) {
  const AccessRule& rule = draft.settings.rules[at];
  const auto& set = rule.registers;
  const auto devices = devices_of(draft.settings, rule);
  if (set.spans.empty() && names_by_profile(set)) {
    if (std::ranges::none_of(devices,
                             [&](const auto* it) { return has_named(it->profile, set); })) {
      warn(draft, at, "no profile of its devices has what 'registers' names");
    }
    return;
  }
  const bool only_read =
      !set.spans.empty() && !names_by_profile(set) &&
      std::ranges::all_of(set.spans, [](const auto& span) { return is_read_only(span.table); });
  const bool same_table =
      std::ranges::any_of(devices, [](const auto* it) { return it->profile.input_as_holding; });
  if (only_read && !same_table && rule.access == RuleAccess::write) {
    warn(draft, at, "its registers can only be read");
  }
}

bool is_reached_by(const Settings& settings, const routing::ResolvedRoute* found,
                   const AccessRule& rule, std::uint8_t unit) {
  if (settings.status_unit == unit) {
    return rule.devices.empty();
  }
  if (found == nullptr ||
      (rule.functions && (*rule.functions & found->route.functions.codes()).none())) {
    return false;
  }
  return rule.devices.empty() ||
         std::ranges::any_of(devices_of(settings, rule),
                             [&](const auto* device) { return found->leads_to(*device, unit); });
}

void check_units(Draft& draft, const routing::RouteTable& table, std::size_t at) {
  const AccessRule& rule = draft.settings.rules[at];
  for (const ListenerId id : listeners_of(draft.settings, rule)) {
    for (std::size_t at_unit = 0; at_unit < routing::UnitSet().size(); ++at_unit) {
      const auto unit = static_cast<std::uint8_t>(at_unit);
      if ((!rule.units || rule.units->test(unit)) &&
          is_reached_by(draft.settings, table.find(id, unit), rule, unit)) {
        return;
      }
    }
  }
  warn(draft, at, "no unit of its listeners leads to its devices and buses");
}

void check_hidden(Draft& draft, std::size_t at) {
  const auto& rules = draft.settings.rules;
  for (std::size_t earlier = 0; earlier < at; ++earlier) {
    if (hides(rules[earlier], rules[at])) {
      warn(draft, at,
           "all that it matches is already decided by the rule at " +
               place(draft.document, draft.rules[earlier].position()));
      return;
    }
  }
}

}  // namespace

void check_rules(Draft& draft, const routing::RouteTable& table) {
  for (std::size_t at = 0; at < draft.settings.rules.size(); ++at) {
    check_roles(draft, at);
    check_addresses(draft, at);
    check_functions(draft, at);
    check_registers(draft, at);
    check_units(draft, table, at);
    check_hidden(draft, at);
  }
  for (std::size_t group = 0; group < draft.groups.size(); ++group) {
    if (!draft.groups_named[group]) {
      draft.group_tables[group].warning("name", "no [[rule]] names this group");
    }
  }
}

}  // namespace mbgate::config
