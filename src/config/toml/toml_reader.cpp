// SPDX-License-Identifier: Apache-2.0
// The only file that sees toml++. Its errors are values here, not exceptions, and the library is
// compiled in: the shared one is built with exceptions.
#include "config/toml/toml_reader.hpp"

#undef TOML_SHARED_LIB
#undef TOML_HEADER_ONLY
#define TOML_HEADER_ONLY 1
#define TOML_EXCEPTIONS 0
// Of lists and inline tables; each may hold dotted keys as long as a line. All of it is recursion.
#define TOML_MAX_NESTED_VALUES 8
// It takes two things for impossible that stand in wrong texts: a key that begins with no letter of
// keys is asserted away two lines before it is reported as an error (3.3), and a letter such as
// U+00E4 outside of strings reaches an "unreachable" in the question whether it is white space (3.3
// and 3.4, which names its parts otherwise). Wrong text must not end the process.
#undef NDEBUG
#define TOML_ASSERT(expr) static_assert(true)
#if __has_include(<toml++/impl/unicode.h>)
#include <toml++/impl/forward_declarations.h>
#else
#include <toml++/impl/forward_declarations.hpp>
#endif
#pragma push_macro("TOML_UNREACHABLE")
#undef TOML_UNREACHABLE
#define TOML_UNREACHABLE return false
#if __has_include(<toml++/impl/unicode.h>)
#include <toml++/impl/unicode.h>
#else
#include <toml++/impl/unicode.hpp>
#endif
#pragma pop_macro("TOML_UNREACHABLE")
#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <cctype>

namespace mbgate::config {
namespace {

/// Bounds how deep dotted keys can nest in one value.
constexpr std::size_t kLongestLine = 4096;
/// No key lies as deep: what does is wrong further up, and is not looked at.
constexpr std::size_t kDeepest = 16;
constexpr std::size_t kShownOfLongLine = 80;
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

/// From the library's values to ours.
struct Conversion {
  std::uint32_t file;  ///< that they stand in

  [[nodiscard]] Position position_of(const toml::source_region& region) const {
    return {region.begin.line, region.begin.column, file};
  }

  [[nodiscard]] TomlTableValue table_of(const toml::table& table, const std::string& path,
                                        bool in_array, std::size_t depth) const {
    TomlTableValue converted;
    converted.position = position_of(table.source());
    if (!path.empty()) {
      converted.title = in_array ? fmt::format("[[{}]]", path) : fmt::format("[{}]", path);
    }
    for (const auto& [key, value] : table) {
      const std::string name(key.str());
      std::string below = path;
      below.append(path.empty() ? "" : ".").append(name);
      converted.entries.push_back(
          {name, position_of(key.source()), value_of(value, below, false, depth + 1)});
    }
    return converted;
  }

  [[nodiscard]] TomlValue value_of(const toml::node& node, const std::string& path, bool in_array,
                                   std::size_t depth) const {
    TomlValue converted{position_of(node.source()), TomlOther{}};
    if (depth > kDeepest) {
      return converted;
    }
    if (const auto* inner = node.as_table()) {
      converted.data = table_of(*inner, path, in_array, depth);
    } else if (const auto* array = node.as_array()) {
      std::vector<TomlValue> elements;
      for (const auto& element : *array) {
        elements.push_back(value_of(element, path, true, depth + 1));
      }
      converted.data = std::move(elements);
    } else if (const auto* string = node.as_string()) {
      converted.data = string->get();
    } else if (const auto* integer = node.as_integer()) {
      converted.data = integer->get();
    } else if (const auto* number = node.as_floating_point()) {
      converted.data = number->get();
    } else if (const auto* boolean = node.as_boolean()) {
      converted.data = boolean->get();
    }
    return converted;
  }
};

/// Words for which TOML has values, or that are meant for them.
constexpr std::array<std::string_view, 8> kTruths = {"true", "false", "inf", "nan",
                                                     "yes",  "no",    "on",  "off"};

struct Rewording {
  std::string_view library;
  std::string_view ours;
};

/// What people get wrong most often, in words that say what to do.
constexpr std::array kRewordings = {
    Rewording{"string: unescaped control characters",
              "the string does not end on its line: expected a closing quote"},
    Rewording{"value: could not determine value type",
              "expected a value: a number, true, false, or a string in quotes"},
    Rewording{"value: exceeded maximum nested value depth", "a value is nested too deep"},
};

/// The library's words, without the part that every error has and without control characters.
std::string syntax_message(std::string_view description) {
  constexpr std::string_view kOpening = "Error while parsing ";
  if (description.starts_with(kOpening)) {
    description.remove_prefix(kOpening.size());
  }
  for (const auto& [library, ours] : kRewordings) {
    if (description.starts_with(library)) {
      description = ours;
    }
  }
  std::string message = "syntax: ";
  for (const char byte : description) {
    if (byte == '\n') {
      message += "\\n";
    } else if (static_cast<unsigned char>(byte) >= 0x20U) {
      message += byte;
    }
  }
  return message;
}

/// A word, an address or a duration that stands alone behind the equals sign of a line; empty if
/// something else does. What TOML itself knows as a value is none.
std::string_view bare_value(std::string_view line) {
  constexpr std::string_view kWhite = " \t";
  const auto equals = line.find('=');
  const auto begin = line.find_first_not_of(kWhite, equals == line.npos ? equals : equals + 1);
  if (begin == line.npos) {
    return {};
  }
  auto value = line.substr(begin, line.find('#', begin) - begin);
  value = value.substr(0, value.find_last_not_of(kWhite) + 1);
  const bool plain = std::ranges::all_of(value, [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
           std::string_view("_-./:").find(c) != std::string_view::npos;
  });
  if (!plain || value.empty() || std::ranges::find(kTruths, value) != kTruths.end()) {
    return {};
  }
  const bool word = std::isalpha(static_cast<unsigned char>(value.front())) != 0 ||
                    value.find_first_of("/:") != line.npos;
  const bool address = std::ranges::count(value, '.') > 1;
  return word || address || parse_duration(value) ? value : std::string_view{};
}

std::vector<std::string> split_lines(std::string_view text) {
  std::vector<std::string> lines;
  while (!text.empty()) {
    const auto end = text.find('\n');
    auto line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (line.ends_with('\r')) {
      line.remove_suffix(1);
    }
    lines.emplace_back(line);
  }
  return lines;
}

}  // namespace

void TomlDocument::report_syntax(Position position, std::string_view description) {
  const auto& lines = files_[position.file].lines;
  const bool known = position.line >= 1 && position.line <= lines.size();
  const std::string_view line = known ? lines[position.line - 1] : std::string_view();
  const auto bare = bare_value(line);
  if (bare.empty()) {
    error(position, syntax_message(description));
    return;
  }
  position.column = static_cast<std::uint32_t>(bare.data() - line.data()) + 1;
  error(position,
        fmt::format("syntax: quotes are missing: expected {}, found {}", in_quotes(bare), bare));
}

std::optional<TomlTableValue> TomlDocument::read_file(std::uint32_t number, std::string_view text) {
  File& file = files_[number];
  if (text.size() > kLargestFile) {
    error({.file = number}, "is larger than 1 MiB: expected a configuration");
    return std::nullopt;
  }
  if (text.starts_with(kByteOrderMark)) {
    text.remove_prefix(kByteOrderMark.size());
  }
  file.lines = split_lines(text);
  const auto longest = std::ranges::max_element(file.lines, {}, &std::string::size);
  if (longest != file.lines.end() && longest->size() > kLongestLine) {
    const auto line = static_cast<std::uint32_t>(longest - file.lines.begin()) + 1;
    longest->resize(kShownOfLongLine);
    error({line, 1, number}, "the line is longer than 4096 bytes");
    return std::nullopt;
  }
  const Conversion conversion{number};
  const auto result = toml::parse(text, std::string_view(file.name));
  if (!result) {
    report_syntax(conversion.position_of(result.error().source()), result.error().description());
    return std::nullopt;
  }
  return conversion.table_of(result.table(), "", false, 0);
}

}  // namespace mbgate::config
