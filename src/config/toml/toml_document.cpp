// SPDX-License-Identifier: Apache-2.0
// Joins the contents of the files of a document, and collects their errors.
#include <algorithm>
#include <fmt/core.h>
#include <iterator>

#include "config/toml/suggestion.hpp"
#include "config/toml/toml_reader.hpp"

namespace mbgate::config {
namespace {

/// Only a table that somebody looked into can have unknown keys; the others are unknown themselves,
/// or were reported as something else.
bool was_looked_into(const TomlTableValue& table) { return !table.known.empty(); }

/// `[[key]]`, or the same in another notation. An empty list says that there is nothing, so another
/// file cannot add to it.
bool is_list_of_tables(const TomlValue& value) {
  const auto* list = std::get_if<std::vector<TomlValue>>(&value.data);
  return list != nullptr && !list->empty() &&
         std::ranges::all_of(*list, [](const TomlValue& element) {
           return std::holds_alternative<TomlTableValue>(element.data);
         });
}

}  // namespace

TomlDocument TomlDocument::parse(const std::vector<TextFile>& files) {
  TomlDocument document;
  std::vector<TomlTableValue> roots;
  for (const auto& file : files) {
    const auto number = static_cast<std::uint32_t>(document.files_.size());
    document.files_.push_back({file.name, {}});
    if (!file.failure.empty()) {
      document.error({.file = number}, file.failure);
    } else if (auto root = document.read_file(number, file.text)) {
      roots.push_back(*std::move(root));
    }
  }
  document.parsed_ = roots.size() == files.size();
  for (std::size_t i = 0; document.parsed_ && i < roots.size(); ++i) {
    if (i == 0) {
      *document.root_ = std::move(roots[i]);
    } else {
      document.join(*document.root_, std::move(roots[i]));
    }
  }
  return document;
}

void TomlDocument::join(TomlTableValue& table, TomlTableValue added) {
  for (auto& entry : added.entries) {
    const auto same = std::ranges::find(table.entries, entry.key, &TomlEntry::key);
    if (same == table.entries.end()) {
      table.entries.push_back(std::move(entry));
    } else {
      join(*same, std::move(entry));
    }
  }
}

void TomlDocument::join(TomlEntry& entry, TomlEntry added) {
  TomlValue& value = entry.value;
  auto* const table = std::get_if<TomlTableValue>(&value.data);
  auto* const more = std::get_if<TomlTableValue>(&added.value.data);
  if (table != nullptr && more != nullptr) {
    join(*table, std::move(*more));
  } else if (is_list_of_tables(value) && is_list_of_tables(added.value)) {
    std::ranges::move(std::get<std::vector<TomlValue>>(added.value.data),
                      std::back_inserter(std::get<std::vector<TomlValue>>(value.data)));
  } else {
    const bool is_alike = value.data.index() == added.value.data.index();
    error(added.position,
          fmt::format("{}: is already set at {}{}", entry.key, place(*this, entry.position),
                      is_alike ? ""
                               : fmt::format(", as {}; here it is {}", describe(value),
                                             describe(added.value))));
  }
}

TomlTable TomlDocument::root() { return {*this, *root_}; }

void TomlDocument::error(Position position, std::string message) {
  report(Severity::error, position, std::move(message));
}

void TomlDocument::warning(Position position, std::string message) {
  report(Severity::warning, position, std::move(message));
}

void TomlDocument::report(Severity severity, Position position, std::string message) {
  std::string line;
  const File& file = files_[position.file];
  if (position.line >= 1 && position.line <= file.lines.size()) {
    line = file.lines[position.line - 1];
  }
  diagnostics_.push_back({severity, file.name, position, std::move(message), std::move(line)});
}

void TomlDocument::report_unknown_keys(const TomlTableValue& table) {
  if (!was_looked_into(table)) {
    return;
  }
  const std::vector<std::string_view> known(table.known.begin(), table.known.end());
  for (const auto& entry : table.entries) {
    if (std::ranges::find(known, entry.key) == known.end()) {
      error(entry.position, fmt::format("unknown key '{}'{}{}", entry.key,
                                        table.title.empty() ? "" : " in " + table.title,
                                        did_you_mean_key(entry.key, known)));
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

std::string place(const TomlDocument& document, Position position) {
  return fmt::format("{}:{}:{}", document.name(position), position.line, position.column);
}

}  // namespace mbgate::config
