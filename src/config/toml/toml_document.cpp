// SPDX-License-Identifier: Apache-2.0
// What a document does besides parsing: it collects what is wrong.
#include <algorithm>

#include "config/toml/suggestion.hpp"
#include "config/toml/toml_reader.hpp"

namespace mbgate::config {
namespace {

/// Only a table that somebody looked into can have unknown keys; the others are unknown themselves,
/// or were reported as something else.
bool was_looked_into(const TomlTableValue& table) { return !table.known.empty(); }

}  // namespace

TomlTable TomlDocument::root() { return {*this, *root_}; }

void TomlDocument::error(Position position, std::string message) {
  report(Severity::error, position, std::move(message));
}

void TomlDocument::warning(Position position, std::string message) {
  report(Severity::warning, position, std::move(message));
}

void TomlDocument::report(Severity severity, Position position, std::string message) {
  std::string line;
  if (position.line >= 1 && position.line <= lines_.size()) {
    line = lines_[position.line - 1];
  }
  diagnostics_.push_back({severity, name_, position, std::move(message), std::move(line)});
}

void TomlDocument::report_unknown_keys(const TomlTableValue& table) {
  if (!was_looked_into(table)) {
    return;
  }
  const std::vector<std::string_view> known(table.known.begin(), table.known.end());
  for (const auto& entry : table.entries) {
    if (std::ranges::find(known, entry.key) == known.end()) {
      error(entry.position, "unknown key '" + entry.key + "'" +
                                (table.title.empty() ? "" : " in " + table.title) +
                                did_you_mean_key(entry.key, known));
    } else if (const auto* inner = std::get_if<TomlTableValue>(&entry.value.data)) {
      report_unknown_keys(*inner);
    } else if (const auto* list = std::get_if<std::vector<TomlValue>>(&entry.value.data)) {
      for (const auto& element : *list) {
        if (const auto* in_list = std::get_if<TomlTableValue>(&element.data)) {
          report_unknown_keys(*in_list);
        }
      }
    }
  }
}

std::vector<Diagnostic> TomlDocument::finish() {
  report_unknown_keys(*root_);
  std::ranges::stable_sort(diagnostics_, {}, &Diagnostic::position);
  return std::move(diagnostics_);
}

}  // namespace mbgate::config
