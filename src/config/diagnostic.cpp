// SPDX-License-Identifier: Apache-2.0
#include "config/diagnostic.hpp"

#include <algorithm>
#include <fmt/core.h>
#include <string_view>

#include "config/sections/sections.hpp"

namespace mbgate::config {
namespace {

bool continues_character(char byte) {
  return (static_cast<unsigned char>(byte) & 0xC0U) == 0x80U;  // UTF-8, RFC 3629
}

bool is_control(char byte) { return static_cast<unsigned char>(byte) < 0x20U || byte == '\x7F'; }

/// A terminal must not obey what stands in a file; the tab stays, the caret's indent repeats it.
std::string printable(std::string_view line) {
  std::string text(line);
  std::ranges::replace_if(
      text, [](char byte) { return is_control(byte) && byte != '\t'; }, ' ');
  return text;
}

std::string caret_indent(std::string_view line, std::uint32_t column) {
  std::string indent;
  for (const char byte : line) {
    if (continues_character(byte)) {
      continue;
    }
    if (indent.size() + 1 >= column) {
      break;
    }
    indent += byte == '\t' ? '\t' : ' ';
  }
  return indent;
}

std::string place_of_key(const Draft& draft, TomlTable& table, std::string_view key) {
  return table.has(key) ? line_of(draft, table.value_position(key)) : std::string();
}

RoutePlaces places_of_route(const Draft& draft, TomlTable& table) {
  auto windows = table.tables("registers");
  return {line_of(draft, table.value_position("access")),
          line_of(draft, table.value_position("functions")),
          line_of(draft, windows.empty() ? table.position() : windows.front().position())};
}

}  // namespace

std::string headline(const Diagnostic& diagnostic) {
  std::string text = diagnostic.file + ":";
  if (diagnostic.position.line != 0) {
    text += fmt::format("{}:{}:", diagnostic.position.line, diagnostic.position.column);
  }
  text += diagnostic.severity == Severity::error ? " error: " : " warning: ";
  return text + diagnostic.message;
}

std::string render(const Diagnostic& diagnostic) {
  std::string text = headline(diagnostic) + "\n";
  if (diagnostic.position.line != 0) {
    const std::string line = printable(diagnostic.source_line);
    text += fmt::format("{}\n{}^\n", line, caret_indent(line, diagnostic.position.column));
  }
  return text;
}

std::string render(const std::vector<Diagnostic>& diagnostics) {
  std::string text;
  for (const auto& diagnostic : diagnostics) {
    text += render(diagnostic);
  }
  return text;
}

bool has_errors(const std::vector<Diagnostic>& diagnostics) {
  return std::ranges::any_of(diagnostics, [](const Diagnostic& diagnostic) {
    return diagnostic.severity == Severity::error;
  });
}

KeyPlaces find_key_places(Draft& draft) {
  KeyPlaces places;
  for (TomlTable& table : draft.listeners) {
    places.listeners.push_back(
        {place_of_key(draft, table, "allow"), place_of_key(draft, table, "read_only")});
  }
  for (TomlTable& table : draft.routes) {
    places.routes.push_back(places_of_route(draft, table));
  }
  for (TomlTable& table : draft.devices) {
    places.writers.push_back(place_of_key(draft, table, "writer"));
  }
  return places;
}

}  // namespace mbgate::config
