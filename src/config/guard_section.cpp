// SPDX-License-Identifier: Apache-2.0
// Who may write to a device, and what is written to it when nobody is left who might.
#include <array>

#include "config/sections.hpp"

namespace mbgate::config {
namespace {

using gateway::DeviceGuard;
using gateway::WriterRule;
using namespace std::chrono_literals;

void read_writer(TomlTable& table, DeviceGuard& guard) {
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
    guard.writers = read_networks(table, "writer");
  } else {
    table.report_expected("writer", *found,
                          R"("any", "first", or a list of addresses such as ["192.168.10.5"])");
  }
}

void read_hold(TomlTable& table, DeviceGuard& guard) {
  assign(guard.writer_hold, table.duration("writer_hold", {1ms, 1h}));
  if (table.has("writer_hold") && guard.writer != WriterRule::first) {
    table.warning("writer_hold", "does nothing without writer = \"first\"");
  }
}

void read_occasions(TomlTable& table, DeviceGuard& guard) {
  assign(guard.quiet, table.duration("quiet", {10ms, 24h, true}));
  assign(guard.failsafe_on_exit, table.boolean("failsafe_on_exit"));
  const auto* writes = table.value("failsafe");
  const bool has_writes = writes != nullptr && !is_empty_list(*writes);
  if (table.has("quiet") && !has_writes) {
    table.error("quiet", "needs 'failsafe': what is written after so long a silence");
  }
  if (table.has("failsafe_on_exit") && !has_writes) {
    table.error("failsafe_on_exit", "needs 'failsafe': what is written when the gateway stops");
  }
}

}  // namespace

gateway::DeviceGuard read_guard(TomlTable& table, const drive::Device& device) {
  DeviceGuard guard;
  read_writer(table, guard);
  read_hold(table, guard);
  guard.failsafe = read_failsafe(table, device);
  read_occasions(table, guard);
  return guard;
}

}  // namespace mbgate::config
