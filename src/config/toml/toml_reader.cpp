// SPDX-License-Identifier: Apache-2.0
// The only file that sees toml++. Its errors are values here, not exceptions, and the library is
// compiled in: the shared one is built with exceptions.
#include "config/toml/toml_reader.hpp"

#undef TOML_SHARED_LIB
#undef TOML_HEADER_ONLY
#define TOML_HEADER_ONLY 1
#define TOML_EXCEPTIONS 0
// Version 3.3 takes two things for impossible that stand in wrong texts: a key that begins with no
// letter of keys is asserted away two lines before it is reported as an error, and a letter such as
// U+00E4 outside of strings reaches an "unreachable" in the question whether it is white space.
// Wrong text must not end the process.
#undef NDEBUG
#define TOML_ASSERT(expr) static_assert(true)
#if __has_include(<toml++/impl/unicode.h>)  // later versions name their parts otherwise
#include <toml++/impl/forward_declarations.h>
#pragma push_macro("TOML_UNREACHABLE")
#undef TOML_UNREACHABLE
#define TOML_UNREACHABLE return false
#include <toml++/impl/unicode.h>
#pragma pop_macro("TOML_UNREACHABLE")
#endif
#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <fstream>
#include <system_error>

#include "config/toml/duration_text.hpp"

namespace mbgate::config {
namespace {

/// A configuration is written by hand; what is larger was named by mistake.
constexpr std::size_t kLargestFile = 1024UL * 1024UL;
/// Bounds how deep dotted keys can nest; lists may span lines.
constexpr std::size_t kLongestLine = 4096;
constexpr std::size_t kShownOfLongLine = 80;
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

Position position_of(const toml::source_region& region) {
  return {region.begin.line, region.begin.column};
}

TomlValue convert(const toml::node& node, const std::string& path, bool in_array);

TomlTableValue convert_table(const toml::table& table, const std::string& path, bool in_array) {
  TomlTableValue converted;
  converted.position = position_of(table.source());
  if (!path.empty()) {
    converted.title = in_array ? "[[" + path + "]]" : "[" + path + "]";
  }
  for (const auto& [key, value] : table) {
    const std::string name(key.str());
    std::string below = path;
    below.append(path.empty() ? "" : ".").append(name);
    converted.entries.push_back({name, position_of(key.source()), convert(value, below, false)});
  }
  return converted;
}

TomlValue convert(const toml::node& node, const std::string& path, bool in_array) {
  TomlValue converted{position_of(node.source()), TomlOther{}};
  if (const auto* table = node.as_table()) {
    converted.data = convert_table(*table, path, in_array);
  } else if (const auto* array = node.as_array()) {
    std::vector<TomlValue> elements;
    for (const auto& element : *array) {
      elements.push_back(convert(element, path, true));
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

std::string reason(int error) { return std::error_code(error, std::generic_category()).message(); }

}  // namespace

TomlDocument::TomlDocument(std::string name)
    : name_(std::move(name)), root_(std::make_unique<TomlTableValue>()) {}

TomlDocument TomlDocument::load(const std::filesystem::path& path) {
  TomlDocument failed(path.string());
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    failed.error({}, "cannot be read: " + reason(EISDIR));
    return failed;
  }
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    failed.error({}, "cannot be read: " + reason(errno == 0 ? EIO : errno));
    return failed;
  }
  std::string text(kLargestFile + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.bad()) {
    failed.error({}, "cannot be read: " + reason(errno == 0 ? EIO : errno));
    return failed;
  }
  text.resize(static_cast<std::size_t>(file.gcount()));
  return parse(path.string(), text);
}

void TomlDocument::report_syntax(Position position, std::string_view description) {
  const bool known = position.line >= 1 && position.line <= lines_.size();
  const std::string_view line = known ? lines_[position.line - 1] : std::string_view();
  const auto bare = bare_value(line);
  if (bare.empty()) {
    error(position, syntax_message(description));
    return;
  }
  const auto column = static_cast<std::uint32_t>(bare.data() - line.data()) + 1;
  error({position.line, column},
        "syntax: quotes are missing: expected " + in_quotes(bare) + ", found " + std::string(bare));
}

TomlDocument TomlDocument::parse(std::string name, std::string_view text) {
  TomlDocument document(std::move(name));
  if (text.size() > kLargestFile) {
    document.error({}, "is larger than 1 MiB: expected a configuration");
    return document;
  }
  if (text.starts_with(kByteOrderMark)) {
    text.remove_prefix(kByteOrderMark.size());
  }
  document.lines_ = split_lines(text);
  const auto longest = std::ranges::max_element(document.lines_, {}, &std::string::size);
  if (longest != document.lines_.end() && longest->size() > kLongestLine) {
    const auto line = static_cast<std::uint32_t>(longest - document.lines_.begin()) + 1;
    longest->resize(kShownOfLongLine);
    document.error({line, 1}, "the line is longer than 4096 bytes");
    return document;
  }
  const auto result = toml::parse(text, std::string_view(document.name_));
  if (!result) {
    document.report_syntax(position_of(result.error().source()), result.error().description());
    return document;
  }
  *document.root_ = convert_table(result.table(), "", false);
  document.parsed_ = true;
  return document;
}

}  // namespace mbgate::config
