// SPDX-License-Identifier: Apache-2.0
// What a route lets through: access, functions, word order, register windows, the deadline.
#include <array>

#include "config/sections/sections.hpp"
#include "config/toml/match_entry.hpp"

namespace mbgate::config {
namespace {

using modbus::Table;
using routing::Access;
using routing::AddressWindow;
using routing::FunctionRules;
using routing::Route;
using namespace std::chrono_literals;

constexpr std::array kRouteAccesses = {Word{"read-only", Access::read_only},
                                       Word{"read-write", Access::read_write}};
constexpr std::int64_t kTableSize = 65536;
constexpr std::size_t kDiagnostics = 8;
/// Sub-functions that silence a device, each named by itself.
constexpr std::array kSilencing = {Word{"8/1", &FunctionRules::restart_communications},
                                   Word{"8/3", &FunctionRules::change_delimiter},
                                   Word{"8/4", &FunctionRules::force_listen_only}};

/// Takes one element of `functions` over; false if it is none.
bool allow(const TomlValue& element, FunctionRules& rules) {
  if (const auto* code = std::get_if<std::int64_t>(&element.data)) {
    if (*code < 1 || *code > 127) {
      return false;
    }
    rules.allowed.set(static_cast<std::size_t>(*code));
    return true;
  }
  const auto* text = std::get_if<std::string>(&element.data);
  if (text == nullptr) {
    return false;
  }
  const auto named = value_of(kSilencing, *text);
  if (!named) {
    return false;
  }
  rules.*(*named) = true;
  return true;
}

/// Only ASCII lines have a delimiter (Serial Line V1.02, 2.5.2.1).
bool has_delimiter(const Draft& draft, const Route& route) {
  return std::ranges::any_of(route.buses, [&](drive::BusId bus) {
    return index(bus) < draft.settings.buses.size() &&
           draft.settings.bus(bus).line.framing == bus::Framing::ascii;
  });
}

void read_functions(const Draft& draft, TomlTable& table, Route& route, bool broadcast) {
  const auto* elements = table.list("functions");
  if (elements == nullptr) {
    route.functions.change_delimiter =
        route.functions.change_delimiter && !has_delimiter(draft, route);
    return;
  }
  FunctionRules rules;
  for (const auto& element : *elements) {
    const auto* code = std::get_if<std::int64_t>(&element.data);
    if (!allow(element, rules)) {
      table.report_expected("functions", element,
                            R"(a function code from 1 to 127, "8/1", "8/3" or "8/4")");
    } else if (broadcast && (code == nullptr ||
                             !modbus::is_broadcast_function(static_cast<std::uint8_t>(*code)))) {
      table.report_expected("functions", element, "a function of broadcasts (5, 6, 15 or 16)");
    }
  }
  if (elements->empty()) {
    table.error("functions", "an empty list lets nothing through");
  }
  rules.change_delimiter =
      rules.change_delimiter || (rules.allowed.test(kDiagnostics) && !has_delimiter(draft, route));
  route.functions = rules;
  route.functions_named = true;
}

/// One side of a window; the last address must exist.
void check_end(TomlTable& window, std::string_view key, std::int64_t first, std::int64_t count) {
  if (first + count > kTableSize) {
    window.error(key, "{} + {} passes 65536, the size of a table", first, count);
  }
}

/// A broadcast is a write: neither side may be a table that can only be read.
std::optional<Table> read_table(TomlTable& window, std::string_view key, bool broadcast) {
  const auto table = window.word<Table>(key, kTables);
  if (broadcast && table && *table != Table::coils && *table != Table::holding_registers) {
    window.report_expected(key, *window.value(key),
                           R"(a table that a broadcast can write, "coils" or "holding")");
  }
  return table;
}

/// Bits and registers cannot become each other.
Table read_to_table(TomlTable& window, std::optional<Table> table, bool broadcast) {
  const auto to_table = read_table(window, "to_table", broadcast);
  if (table && to_table && modbus::holds_bits(*table) != modbus::holds_bits(*to_table)) {
    window.report_expected("to_table", *window.value("to_table"),
                           modbus::holds_bits(*table)
                               ? R"(another table of bits, "coils" or "discrete")"
                               : R"(another table of registers, "input" or "holding")");
  }
  return to_table.value_or(table.value_or(Table::holding_registers));
}

/// Nothing if a number is missing or wrong.
std::optional<AddressWindow> read_window(TomlTable& window, bool broadcast) {
  window.require_all({"table", "from", "count", "to"});
  const auto table = read_table(window, "table", broadcast);
  const auto to_table = read_to_table(window, table, broadcast);
  const auto from = window.integer("from", {0, kTableSize - 1});
  const auto count = window.integer("count", {1, kTableSize});
  const auto to = window.integer("to", {0, kTableSize - 1});
  if (from && count) {
    check_end(window, "from", *from, *count);
  }
  if (to && count) {
    check_end(window, "to", *to, *count);
  }
  if (!table || !from || !count || !to) {
    return std::nullopt;
  }
  return AddressWindow{*table, static_cast<std::uint16_t>(*from),
                       static_cast<std::uint32_t>(*count), to_table,
                       static_cast<std::uint16_t>(*to)};
}

bool same_client_addresses(const AddressWindow& a, const AddressWindow& b) {
  return a.table == b.table && a.from < b.from + b.count && b.from < a.from + a.count;
}

void read_windows(TomlTable& table, Route& route, bool broadcast) {
  if (const auto* list = table.list("registers"); list != nullptr && list->empty()) {
    table.error("registers",
                "an empty list is no window: leave the key out to let everything through");
  }
  std::vector<TomlTable> places;
  for (auto& entry : table.tables("registers")) {
    route.functions = FunctionRules::rewritable();
    const auto window = read_window(entry, broadcast);
    if (!window) {
      continue;
    }
    const auto same = std::ranges::find_if(
        route.windows, [&](const auto& other) { return same_client_addresses(other, *window); });
    if (same != route.windows.end()) {
      const auto& first = places[static_cast<std::size_t>(same - route.windows.begin())];
      entry.error("from", "{} to {} overlap the window at {}", window->from,
                  window->from + window->count - 1, first.place_of("from"));
    }
    route.windows.push_back(*window);
    places.push_back(entry);
  }
}

}  // namespace

void read_route_rules(const Draft& draft, TomlTable& table, Route& route, bool broadcast) {
  assign(route.access, table.word<Access>("access", kRouteAccesses));
  if (broadcast && route.access == Access::read_only) {
    table.error("access", "a broadcast is a write: \"read-only\" would let nothing through");
  }
  assign(route.word_order, table.word<drive::WordOrder>("word_order", kWordOrders));
  if (route.word_order && !broadcast && !table.has("device")) {
    table.error("word_order",
                "belongs to a route with 'device': the values of a plain address are not known");
  }
  read_windows(table, route, broadcast);
  read_functions(draft, table, route, broadcast);
  assign(route.deadline, table.duration("deadline", {1ms, 1h}));
}

}  // namespace mbgate::config
