// SPDX-License-Identifier: Apache-2.0
// Who may do what: [[group]] and [[rule]], in the order in which they stand.
#include <array>
#include <charconv>

#include "config/sections/sections.hpp"
#include "config/toml/match_entry.hpp"

namespace mbgate::config {
namespace {

using routing::AccessRule;
using routing::ClientGroup;
using routing::RuleAccess;

constexpr std::array kRuleActions = {Word{"permit", true}, Word{"deny", false}};
constexpr std::array kRuleAccesses = {Word{"read", RuleAccess::read},
                                      Word{"write", RuleAccess::write}};
constexpr IntegerRange kRuleUnits = {0, 255};
constexpr IntegerRange kRuleFunctions = {1, 127};
/// A millisecond is what a request takes that goes over no line.
constexpr unsigned kFastestRate = 1000;

/// An empty list would be read as "nobody" by some, and as "everybody" by others.
void check_not_empty(TomlTable& table, std::initializer_list<std::string_view> keys) {
  for (const auto key : keys) {
    const auto* found = table.value(key);
    if (found != nullptr && is_empty_list(*found)) {
      table.error(key, "expected at least one; leave the key out for all of them");
    }
  }
}

std::vector<std::string> read_roles(TomlTable& table) {
  std::vector<std::string> roles;
  for (auto& [text, position] : table.strings("roles").value_or(std::vector<TomlText>())) {
    roles.push_back(std::move(text));
  }
  return roles;
}

/// The indices of the entries that a list names.
template <typename Named>
std::vector<std::size_t> find_each(TomlTable& table, std::string_view key,
                                   const std::vector<Named>& all) {
  std::vector<std::size_t> found;
  for (const auto& [text, position] : table.strings(key).value_or(std::vector<TomlText>())) {
    const auto entry = std::ranges::find(all, text, &Named::name);
    if (entry != all.end()) {
      found.push_back(static_cast<std::size_t>(entry - all.begin()));
    } else {
      table.document().error(position, "{}: no {} is named {}{}", key, kSection<Named>,
                             in_quotes(text), did_you_mean(text, names_of(all)));
    }
  }
  return found;
}

/// Integers, and ranges in strings such as "1-4".
template <std::size_t Size>
std::optional<std::bitset<Size>> read_numbers(TomlTable& table, std::string_view key,
                                              IntegerRange limits, std::string_view what) {
  const auto* elements = table.list(key);
  if (elements == nullptr) {
    return std::nullopt;
  }
  std::bitset<Size> numbers;
  for (const TomlValue& element : *elements) {
    std::optional<IntegerRange> range;
    if (const auto* number = std::get_if<std::int64_t>(&element.data)) {
      range = IntegerRange{*number, *number};
    } else if (const auto* text = std::get_if<std::string>(&element.data)) {
      range = parse_range(*text, limits);
    }
    if (!range || range->min < limits.min || range->max > limits.max) {
      table.report_expected(key, element, "{} from {} to {} or a range such as \"1-4\"", what,
                            limits.min, limits.max);
      continue;
    }
    for (auto number = range->min; number <= range->max; ++number) {
      numbers.set(static_cast<std::size_t>(number));
    }
  }
  return numbers;
}

/// "10/s"; 0 if there is none.
unsigned read_rate(TomlTable& table) {
  const auto text = table.string("rate");
  if (!text) {
    return 0;
  }
  unsigned rate = 0;
  const char* const end = text->data() + text->size();
  const auto [at, error] = std::from_chars(text->data(), end, rate);
  if (error != std::errc{} || std::string_view(at, end) != "/s" || rate == 0 ||
      rate > kFastestRate) {
    table.report_expected("rate", *table.value("rate"),
                          R"(how often a second, from "1/s" to "1000/s")");
    return 0;
  }
  return rate;
}

void read_who(Draft& draft, TomlTable& table, AccessRule& rule) {
  check_not_empty(table, {"clients", "roles", "listeners"});
  for (const std::size_t group : find_each(table, "clients", draft.groups)) {
    rule.clients.push_back(draft.groups[group]);
    draft.groups_named[group] = true;
  }
  for (const std::size_t listener : find_each(table, "listeners", draft.settings.listeners)) {
    rule.listeners.push_back(routing::ListenerId{static_cast<std::uint32_t>(listener)});
  }
  rule.roles = read_roles(table);
  rule.any_role = table.boolean("any_role").value_or(false);
  if (rule.any_role && !rule.roles.empty()) {
    table.error("any_role", "expected either 'roles' or any_role = true, not both");
  }
}

void read_what(Draft& draft, TomlTable& table, AccessRule& rule) {
  check_not_empty(table, {"units", "devices", "functions", "registers"});
  rule.units = read_numbers<256>(table, "units", kRuleUnits, "a unit");
  rule.devices = find_each(table, "devices", draft.settings.devices);
  rule.functions = read_numbers<128>(table, "functions", kRuleFunctions, "a function code");
  rule.registers = read_rule_registers(table);
  assign(rule.access, table.word<RuleAccess>("access", kRuleAccesses));
  rule.per_second = read_rate(table);
}

void read_action(TomlTable& table, AccessRule& rule) {
  table.require("action");
  assign(rule.permits, table.word<bool>("action", kRuleActions));
  if (!rule.permits && table.has("rate")) {
    table.error("rate",
                "belongs to a rule with action = \"permit\": requests over the rate get 06");
  }
}

void read_groups(Draft& draft) {
  for (auto table : draft.document.root().tables("group")) {
    ClientGroup group;
    draft.group_tables.push_back(table);
    group.name = read_name(draft.group_tables, draft.groups);
    check_not_empty(table, {"addresses", "roles"});
    group.addresses = read_networks(table, "addresses");
    group.roles = read_roles(table);
    if (!table.has("addresses") && !table.has("roles")) {
      draft.document.error(table.position(),
                           "[[group]]: has no members: expected 'addresses', 'roles', or both");
    }
    draft.groups.push_back(std::move(group));
  }
  draft.groups_named.resize(draft.groups.size());
}

using routing::RegisterSet;
using routing::RegisterSpan;

constexpr std::array kNamedRegisters = {
    Word{"motion commands", &RegisterSet::motion_commands},
    Word{"communication registers", &RegisterSet::communication_registers},
    Word{"values", &RegisterSet::values},
    Word{"stops", &RegisterSet::stops},
};

constexpr std::string_view kExpected =
    R"(a table ("coils", "discrete", "input" or "holding"), alone or with addresses of the device )"
    R"(such as "holding 124" or "holding 0x7C-0x80"; or "motion commands", )"
    R"("communication registers", "values" or "stops")";

/// "holding", "holding 124" or "holding 0x7C-0x80".
std::optional<RegisterSpan> parse_span(std::string_view text) {
  const auto space = text.find(' ');
  const auto table = value_of(kTables, text.substr(0, space));
  if (!table) {
    return std::nullopt;
  }
  if (space == std::string_view::npos) {
    return RegisterSpan{*table};
  }
  const auto addresses = text.substr(space + 1);
  const auto dash = addresses.find('-');
  const auto first = parse_register_address(addresses.substr(0, dash));
  const auto last =
      dash == std::string_view::npos ? first : parse_register_address(addresses.substr(dash + 1));
  if (!first || !last || *last < *first) {
    return std::nullopt;
  }
  return RegisterSpan{*table, *first, *last};
}

}  // namespace

void read_rules(Draft& draft) {
  read_groups(draft);
  for (auto table : draft.document.root().tables("rule")) {
    AccessRule rule;
    draft.rules.push_back(table);
    if (table.has("name")) {
      rule.name = read_name(draft.rules, draft.settings.rules);
    }
    rule.place = line_of(draft, table.position());
    read_who(draft, table, rule);
    read_what(draft, table, rule);
    read_action(table, rule);
    draft.settings.rules.push_back(std::move(rule));
  }
}

RegisterSet read_rule_registers(TomlTable& table) {
  RegisterSet set;
  for (const auto& [text, position] :
       table.strings("registers").value_or(std::vector<TomlText>())) {
    if (const auto named = value_of(kNamedRegisters, text)) {
      set.*(*named) = true;
    } else if (const auto span = parse_span(text)) {
      set.spans.push_back(*span);
    } else {
      table.report_expected("registers", {position, text}, kExpected);
    }
  }
  return set;
}

}  // namespace mbgate::config
