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

/// Of the keys that are there.
void add_places(const Draft& draft, std::vector<TomlTable>& tables,
                std::initializer_list<std::string_view> keys, KeyPlaces& places) {
  for (std::size_t at = 0; at < tables.size(); ++at) {
    for (const auto key : keys) {
      if (tables[at].has(key)) {
        places[{key, at}] = line_of(draft, tables[at].value_position(key));
      }
    }
  }
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
  add_places(draft, draft.listeners, {"allow", "read_only"}, places);
  add_places(draft, draft.devices, {"writer"}, places);
  for (std::size_t at = 0; at < draft.routes.size(); ++at) {
    TomlTable& route = draft.routes[at];
    const auto windows = route.tables("registers");
    places[{"access", at}] = line_of(draft, route.value_position("access"));
    places[{"functions", at}] = line_of(draft, route.value_position("functions"));
    places[{"windows", at}] =
        line_of(draft, windows.empty() ? route.position() : windows.front().position());
  }
  return places;
}

}  // namespace mbgate::config
