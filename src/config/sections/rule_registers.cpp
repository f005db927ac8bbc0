// SPDX-License-Identifier: Apache-2.0
// The registers that an access rule names, in words.
#include <array>

#include "config/sections/sections.hpp"
#include "config/toml/words.hpp"

namespace mbgate::config {
namespace {

using routing::RegisterSet;
using routing::RegisterSpan;

constexpr std::array kNamedRegisters = {
    Word{"motion commands", &RegisterSet::motion_commands},
    Word{"communication registers", &RegisterSet::communication_registers},
    Word{"values", &RegisterSet::values},
    Word{"stops", &RegisterSet::stops},
};

constexpr std::string_view kExpected =
    R"(a table ("coils", "discrete", "input" or "holding"), alone or with addresses of the device )"
    R"(such as "holding 124" or "holding 0x7C-0x80"; or "motion commands", )"
    R"("communication registers", "values" or "stops")";

/// "holding", "holding 124" or "holding 0x7C-0x80".
std::optional<RegisterSpan> parse_span(std::string_view text) {
  const auto space = text.find(' ');
  const auto word = text.substr(0, space);
  const auto table = std::ranges::find_if(kTables, [&](const auto& it) { return it.text == word; });
  if (table == kTables.end()) {
    return std::nullopt;
  }
  if (space == std::string_view::npos) {
    return RegisterSpan{table->value};
  }
  const auto addresses = text.substr(space + 1);
  const auto dash = addresses.find('-');
  const auto first = parse_register_address(addresses.substr(0, dash));
  const auto last =
      dash == std::string_view::npos ? first : parse_register_address(addresses.substr(dash + 1));
  if (!first || !last || *last < *first) {
    return std::nullopt;
  }
  return RegisterSpan{table->value, *first, *last};
}

}  // namespace

RegisterSet read_rule_registers(TomlTable& table) {
  RegisterSet set;
  for (const auto& [text, position] :
       table.strings("registers").value_or(std::vector<TomlText>())) {
    const auto named =
        std::ranges::find_if(kNamedRegisters, [&](const auto& it) { return it.text == text; });
    if (named != kNamedRegisters.end()) {
      set.*(named->value) = true;
    } else if (const auto span = parse_span(text)) {
      set.spans.push_back(*span);
    } else {
      table.report_expected("registers", {position, text}, kExpected);
    }
  }
  return set;
}

}  // namespace mbgate::config
