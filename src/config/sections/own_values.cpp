// SPDX-License-Identifier: Apache-2.0
// Values that a user names at a device: values32 = { holding = [300, "310-329"], input = [8] }.
#include <fmt/core.h>

#include "config/sections/sections.hpp"
#include "config/toml/match_entry.hpp"

namespace mbgate::config {
namespace {

using drive::overlap;
using drive::Value;
using modbus::Table;

/// A list of one table, and what is needed to say what is wrong in it.
struct OwnList {
  TomlTable* table;      ///< where the list stands,
  std::string_view key;  ///< at this key
  Table of;
  std::uint8_t registers;  ///< of one value
};

std::string numbers(std::uint32_t first, std::uint32_t end) {
  return fmt::format("{} to {}", first, end - 1);
}

/// Empty if the value can be one of the device.
std::string refusal(const Value& value, const ProfileFile* file, const drive::Device& device) {
  const auto& profile = device.profile;
  const auto range = value.range();
  const auto registers = numbers(value.first, value.end());
  if (profile.input_as_holding && value.table == Table::input_registers) {
    return fmt::format("function 04 reads the holding registers of {}: name them there",
                       in_quotes(profile.name));
  }
  if (const auto* other = profile.values.from(value.table, value.first);
      other != nullptr && other->first < value.end()) {
    return fmt::format("{} overlap the value {}", registers, numbers(other->first, other->end()));
  }
  if (file != nullptr) {
    for (const auto& string : file->strings) {
      if (overlap(string.fact, range)) {
        return fmt::format("{} overlap the string {} of {}", registers,
                           numbers(string.fact.first, drive::end_of(string.fact)),
                           in_quotes(profile.name));
      }
    }
  }
  if (profile.group_end(value.table, value.first) < value.end()) {
    return fmt::format("{} reach over the end of a parameter group of {}", registers,
                       in_quotes(profile.name));
  }
  if (profile.is_special(range)) {
    return fmt::format(
        "{} hold a stop, an opcode or its parameters, a communication register, or a write that is "
        "guarded or never answered, of {}",
        registers, in_quotes(profile.name));
  }
  if (value.table == Table::holding_registers && profile.limits.write_registers < value.registers) {
    return fmt::format("{} cannot be written at once: {} takes at most {}", registers,
                       in_quotes(profile.name), profile.limits.write_registers);
  }
  if (profile.limits.read_from(value.table) < value.registers) {
    return fmt::format("{} cannot be read at once: {} reads at most {}", registers,
                       in_quotes(profile.name), profile.limits.read_from(value.table));
  }
  return {};
}

/// An address, or a range of consecutive values.
std::optional<IntegerRange> parse_element(const TomlValue& element, std::uint8_t registers) {
  constexpr std::int64_t kLast = 0xFFFF;
  if (const auto* first = std::get_if<std::int64_t>(&element.data)) {
    return *first >= 0 && *first <= kLast + 1 - registers
               ? std::optional(IntegerRange{*first, *first + registers - 1})
               : std::nullopt;
  }
  const auto* text = std::get_if<std::string>(&element.data);
  const auto range = text == nullptr ? std::nullopt : parse_range(*text, {0, kLast});
  return range && (range->max - range->min + 1) % registers == 0 ? range : std::nullopt;
}

void read_element(const OwnList& list, const TomlValue& element, const ProfileFile* file,
                  drive::Device& device) {
  const auto range = parse_element(element, list.registers);
  if (!range) {
    const std::int64_t last = 0x10000 - list.registers;
    list.table->report_expected(
        list.key, element,
        "the first register of a value, 0 to {}, or a range of whole values such as \"{}\"", last,
        list.registers == 2 ? "310-329" : "400-407");
    return;
  }
  for (auto first = range->min; first < range->max; first += list.registers) {
    const Value value{list.of, static_cast<std::uint16_t>(first), list.registers, false};
    const auto why = refusal(value, file, device);
    if (!why.empty()) {
      list.table->document().error(element.position, "{}: {}", list.key, why);
      return;
    }
    device.profile.values.add(value);
  }
}

void read_list(const OwnList& list, const ProfileFile* file, drive::Device& device) {
  const auto* elements = list.table->list(list.key);
  if (elements == nullptr) {
    return;
  }
  for (const auto& element : *elements) {
    read_element(list, element, file, device);
  }
}

void read_key(TomlTable& table, const OwnList& list, const ProfileFile* file,
              drive::Device& device) {
  const auto* found = table.value(list.key);
  if (found == nullptr) {
    return;
  }
  if (std::holds_alternative<std::vector<TomlValue>>(found->data)) {
    read_list(list, file, device);
  } else if (std::holds_alternative<TomlTableValue>(found->data)) {
    auto by_table = table.table(list.key);
    for (const auto& word : kRegisterTables) {
      read_list({&*by_table, word.text, word.value, list.registers}, file, device);
    }
  } else {
    table.report_expected(list.key, *found, "a list, or { holding = [...], input = [...] }");
  }
}

}  // namespace

void read_own_values(TomlTable& table, const ProfileFile* file, drive::Device& device) {
  read_key(table, {&table, "values32", Table::holding_registers, 2}, file, device);
  read_key(table, {&table, "values64", Table::holding_registers, 4}, file, device);
}

}  // namespace mbgate::config
