// SPDX-License-Identifier: Apache-2.0
// A second implementation of access rules, as naive as can be: it looks at one register after the
// other, and knows by heart what the registers of the devices are.
#pragma once

#include "unit/routing/rule_cases.hpp"

namespace mbgate::test {

/// What each device's registers are, one by one, as plain as it gets.
struct Meaning {
  bool motion = false;
  bool communication = false;
  bool value = false;
};

inline Meaning meaning_of(std::size_t device, Table table, std::uint32_t address) {
  const bool holding =
      table == Table::holding_registers || (device == 1 && table == Table::input_registers);
  Meaning meaning;
  if (!holding || device == 2) {
    return meaning;
  }
  meaning.value = address == 2 || address == 3 || (address >= 6 && address <= 9);
  meaning.motion = address == 2 || address == 3 || address == 11;
  meaning.communication = address == 12 || address == 13;
  return meaning;
}

/// The second implementation. Each function is one sentence of docs/access-rules.md.
class Naive {
 public:
  Naive(const AccessRule& rule, const Case& asked) : rule_(rule), asked_(asked) {}

  [[nodiscard]] bool matches() const {
    return from_one_of_its_clients() && on_its_listener() && for_its_units() &&
           with_its_function() && in_its_direction() && where_it_says();
  }

 private:
  [[nodiscard]] bool from_one_of_its_clients() const {
    if (asked_.role.kind == ClientRole::Kind::unreadable) {
      return false;
    }
    if (rule_.clients.empty()) {
      return role_fits(nullptr);
    }
    bool found = false;
    for (const auto& group : rule_.clients) {
      bool inside = group.addresses.empty();
      for (const auto& network : group.addresses) {
        inside = inside || network.contains(asked_.address);
      }
      found = found || (inside && role_fits(&group));
    }
    return found;
  }
  [[nodiscard]] bool role_fits(const routing::ClientGroup* group) const {
    std::vector<const std::vector<std::string>*> lists{&rule_.roles};
    if (group != nullptr) {
      lists.push_back(&group->roles);
    }
    bool any_list = false;
    for (const auto* list : lists) {
      if (list->empty()) {
        continue;
      }
      any_list = true;
      bool there = false;
      for (const auto& role : *list) {
        there = there || (asked_.role.kind == ClientRole::Kind::named && role == asked_.role.name);
      }
      if (!there) {
        return false;
      }
    }
    return any_list || rule_.any_role || asked_.role.kind == ClientRole::Kind::none;
  }
  [[nodiscard]] bool on_its_listener() const {
    bool found = rule_.listeners.empty();
    for (const auto id : rule_.listeners) {
      found = found || static_cast<std::uint32_t>(id) == asked_.listener;
    }
    return found;
  }
  [[nodiscard]] bool for_its_units() const {
    if (!rule_.units) {
      return true;
    }
    for (std::size_t unit = 0; unit < 256; ++unit) {
      const bool counts = unit == asked_.unit || (!rule_.permits && asked_.reached[unit]);
      if (counts && (*rule_.units)[unit]) {
        return true;
      }
    }
    return false;
  }
  [[nodiscard]] bool with_its_function() const {
    return !rule_.functions || (*rule_.functions)[asked_.function];
  }
  [[nodiscard]] bool in_its_direction() const {
    switch (rule_.access) {
      case RuleAccess::both: return true;
      case RuleAccess::read: return asked_.is_read;
      case RuleAccess::write: return !asked_.is_read;
    }
    return false;
  }
  [[nodiscard]] bool where_it_says() const {
    if (rule_.devices.empty() && rule_.registers.empty()) {
      return true;
    }
    std::size_t inside = 0;
    std::size_t outside = 0;
    for (const auto& touched : asked_.touched) {
      count(touched, inside, outside);
    }
    return rule_.permits ? outside == 0 : inside > 0;
  }
  // Register by register.
  void count(const TouchedRegisters& touched, std::size_t& inside, std::size_t& outside) const {
    bool device_fits = rule_.devices.empty();
    for (const std::size_t device : rule_.devices) {
      device_fits = device_fits || touched.number == device;
    }
    if (!device_fits) {
      ++outside;
      return;
    }
    if (rule_.registers.empty()) {
      ++inside;
      return;
    }
    if (!touched.range) {
      ++outside;
      return;
    }
    for (std::uint32_t i = 0; i < touched.range->count; ++i) {
      const bool named = is_named(touched, touched.range->first + i) || is_named_stop(touched);
      ++(named ? inside : outside);
    }
  }
  // To deny them, whatever holds a stop is one; to permit them, registers that stop are.
  [[nodiscard]] bool is_named_stop(const TouchedRegisters& touched) const {
    if (!rule_.registers.stops) {
      return false;
    }
    return rule_.permits ? touched.stop == StopIn::all : touched.stop != StopIn::none;
  }
  [[nodiscard]] bool is_named(const TouchedRegisters& touched, std::uint32_t address) const {
    for (const auto& span : rule_.registers.spans) {
      if (address >= span.first && address <= span.last &&
          same_table(touched, span.table, touched.range->table)) {
        return true;
      }
    }
    if (!touched.number) {
      return false;
    }
    const Meaning meaning = meaning_of(*touched.number, touched.range->table, address);
    return (rule_.registers.motion_commands && meaning.motion) ||
           (rule_.registers.communication_registers && meaning.communication) ||
           (rule_.registers.values && meaning.value);
  }
  static bool same_table(const TouchedRegisters& touched, Table a, Table b) {
    const auto of_registers = [](Table table) {
      return table == Table::holding_registers || table == Table::input_registers;
    };
    return a == b || (touched.number == std::size_t{1} && of_registers(a) && of_registers(b));
  }

  const AccessRule& rule_;
  const Case& asked_;
};

}  // namespace mbgate::test
