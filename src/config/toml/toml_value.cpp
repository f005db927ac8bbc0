// SPDX-License-Identifier: Apache-2.0
#include "config/toml/toml_value.hpp"

#include <fmt/core.h>

namespace mbgate::config {
namespace {

/// As much of a wrong value as is needed to recognise it.
constexpr std::size_t kMostShown = 60;

struct Describe {
  std::string operator()(const std::string& text) const { return in_quotes(text); }
  std::string operator()(std::int64_t number) const { return std::to_string(number); }
  std::string operator()(double number) const { return fmt::format("{:.12g}", number); }
  std::string operator()(bool truth) const { return truth ? "true" : "false"; }
  std::string operator()(const std::vector<TomlValue>& /*list*/) const { return "a list"; }
  std::string operator()(const TomlTableValue& /*table*/) const { return "a table"; }
  std::string operator()(const TomlOther& /*other*/) const { return "a date or time"; }
};

}  // namespace

std::string describe(const TomlValue& value) { return std::visit(Describe{}, value.data); }

bool is_empty_list(const TomlValue& value) {
  const auto* list = std::get_if<std::vector<TomlValue>>(&value.data);
  return list != nullptr && list->empty();
}

std::string in_quotes(std::string_view text) {
  std::string shown = "\"";
  for (const char byte : text) {
    const auto code = static_cast<unsigned char>(byte);
    const bool starts_character = (code & 0xC0U) != 0x80U;
    if (shown.size() > kMostShown && starts_character) {
      return shown + "...\"";
    }
    if (byte == '\n') {
      shown += "\\n";
    } else if (byte == '\t') {
      shown += "\\t";
    } else {
      shown += code < 0x20U || code == 0x7FU ? '?' : byte;
    }
  }
  return shown + "\"";
}

}  // namespace mbgate::config
