// SPDX-License-Identifier: Apache-2.0
// The clients that may write to a device, and its failsafe writes.
#include <array>
#include <string>
#include <utility>

#include "config/sections/sections.hpp"
#include "config/toml/duration_text.hpp"

namespace mbgate::config {
namespace {

using gateway::DeviceGuard;
using gateway::WriterRule;

void read_writer(Draft& draft, TomlTable& table, DeviceGuard& guard) {
  constexpr std::array kRules = {Word{"any", WriterRule::any}, Word{"first", WriterRule::first}};
  const auto* found = table.value("writer");
  if (found == nullptr) {
    return;
  }
  const auto* text = std::get_if<std::string>(&found->data);
  const auto rule = std::ranges::find_if(
      kRules, [&](const auto& word) { return text != nullptr && *text == word.text; });
  if (rule != kRules.end()) {
    guard.writer = rule->value;
  } else if (is_empty_list(*found)) {
    table.error("writer",
                "expected at least one address; access = \"read-only\" on the routes lets "
                "nobody write");
  } else if (std::holds_alternative<std::vector<TomlValue>>(found->data)) {
    guard.writer = WriterRule::listed;
    guard.writers = read_clients(draft, table, "writer");
  } else {
    table.report_expected("writer", *found,
                          R"("any", "first", or a list of addresses such as ["192.168.10.5"])");
  }
}

void check_hold(TomlTable& table, const DeviceGuard& guard) {
  if (table.has("writer_hold") && guard.writer != WriterRule::first) {
    table.warning("writer_hold", "does nothing without writer = \"first\"");
  }
}

void check_occasions(TomlTable& table, const DeviceGuard& guard) {
  constexpr std::array kNeedWrites = {
      std::pair("failsafe_clients", "when these clients have gone"),
      std::pair("failsafe_grace", "when a client has gone for so long"),
      std::pair("quiet", "after so long a silence"),
      std::pair("failsafe_on_exit", "when the gateway stops")};
  const auto* writes = table.value("failsafe");
  const bool has_writes = writes != nullptr && !is_empty_list(*writes);
  for (const auto& [key, occasion] : kNeedWrites) {
    if (table.has(key) && !has_writes) {
      table.error(key, std::string("needs 'failsafe': what is written ") + occasion);
    }
  }
  if (has_writes && guard.quiet > gateway::Duration{0} && guard.quiet < guard.failsafe_grace) {
    table.warning("quiet", "failsafe_grace, " + to_text(guard.failsafe_grace) +
                               ", is longer, and has to pass too");
  }
}

}  // namespace

gateway::DeviceGuard read_guard(Draft& draft, TomlTable& table, const drive::Device& device) {
  DeviceGuard guard;
  read_keys(table, guard_keys(), guard);
  read_writer(draft, table, guard);
  check_hold(table, guard);
  guard.failsafe_clients = read_clients(draft, table, "failsafe_clients");
  guard.failsafe = read_failsafe(table, device);
  check_occasions(table, guard);
  return guard;
}

}  // namespace mbgate::config
