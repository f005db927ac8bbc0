// SPDX-License-Identifier: Apache-2.0
// What a route lets through: access, functions, the register window, the deadline.
#include <array>

#include "config/sections.hpp"
#include "config/words.hpp"

namespace mbgate::config {
namespace {

using modbus::Table;
using routing::Access;
using routing::AddressWindow;
using routing::FunctionRules;
using routing::Route;
using namespace std::chrono_literals;

constexpr std::array kAccesses = {Word{"read-only", Access::read_only},
                                  Word{"read-write", Access::read_write}};
constexpr std::int64_t kTableSize = 65536;
constexpr std::int64_t kDiagnostics = 8;

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
  if (text == nullptr || (*text != "8/1" && *text != "8/4")) {
    return false;
  }
  rules.allowed.set(kDiagnostics);
  (*text == "8/1" ? rules.restart_communications : rules.force_listen_only) = true;
  return true;
}

void read_functions(TomlTable& table, Route& route, bool broadcast) {
  const auto* elements = table.list("functions");
  if (elements == nullptr) {
    return;
  }
  FunctionRules rules;
  for (const auto& element : *elements) {
    const auto* code = std::get_if<std::int64_t>(&element.data);
    if (!allow(element, rules)) {
      table.report_expected("functions", element,
                            R"(a function code from 1 to 127, "8/1" or "8/4")");
    } else if (broadcast && (code == nullptr ||
                             !modbus::is_broadcast_function(static_cast<std::uint8_t>(*code)))) {
      table.report_expected("functions", element, "a function of broadcasts (5, 6, 15 or 16)");
    }
  }
  if (elements->empty()) {
    table.error("functions", "an empty list lets nothing through");
  }
  route.functions = rules;
}

/// One side of a window; the last address must exist.
void check_end(TomlTable& window, std::string_view key, std::int64_t first, std::int64_t count) {
  if (first + count > kTableSize) {
    window.error(key, std::to_string(first) + " + " + std::to_string(count) +
                          " passes 65536, the size of a table");
  }
}

void read_window(TomlTable& window, Route& route, bool broadcast) {
  AddressWindow read;
  for (const auto* key : {"table", "from", "count", "to"}) {
    window.require(key);
  }
  const auto table = window.word<Table>("table", kTables);
  assign(read.table, table);
  if (broadcast && table && *table != Table::coils && *table != Table::holding_registers) {
    window.report_expected("table", *window.value("table"),
                           R"(a table that a broadcast can write, "coils" or "holding")");
  }
  const auto from = window.integer("from", {0, kTableSize - 1});
  const auto count = window.integer("count", {1, kTableSize});
  const auto to = window.integer("to", {0, kTableSize - 1});
  assign(read.from, from);
  assign(read.count, count);
  assign(read.to, to);
  if (from && count) {
    check_end(window, "from", *from, *count);
  }
  if (to && count) {
    check_end(window, "to", *to, *count);
  }
  read.to_table = read.table;
  route.windows.push_back(read);
  route.functions = FunctionRules::rewritable();
}

void read_windows(TomlTable& table, Route& route, bool broadcast) {
  auto windows = table.tables("registers");
  if (windows.size() > 1) {
    table.document().error(windows[1].position(),
                           "[[route.registers]]: this version knows one window a route");
  }
  for (auto& window : windows) {
    read_window(window, route, broadcast);
  }
}

}  // namespace

void read_route_rules(TomlTable& table, Route& route, bool broadcast) {
  assign(route.access, table.word<Access>("access", kAccesses));
  if (broadcast && route.access == Access::read_only) {
    table.error("access", "a broadcast is a write: \"read-only\" would let nothing through");
  }
  read_windows(table, route, broadcast);
  read_functions(table, route, broadcast);
  assign(route.deadline, table.duration("deadline", {1ms, 1h}));
}

}  // namespace mbgate::config
