// SPDX-License-Identifier: Apache-2.0
// Values that a user names at a device: values32 = { holding = [300, "310-329"], input = [8] }.
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
  return std::to_string(first) + " to " + std::to_string(end - 1);
}

/// Empty if the value can be one of the device.
std::string refusal(const Value& value, const ProfileFile* file, const drive::Device& device) {
  const auto& profile = device.profile;
  const auto range = value.range();
  const auto registers = numbers(value.first, value.end());
  if (profile.input_as_holding && value.table == Table::input_registers) {
    return "function 04 reads the holding registers of " + in_quotes(profile.name) +
           ": name them there";
  }
  if (const auto* other = profile.values.from(value.table, value.first);
      other != nullptr && other->first < value.end()) {
    return registers + " overlap the value " + numbers(other->first, other->end());
  }
  if (file != nullptr) {
    for (const auto& string : file->strings) {
      if (overlap(string.fact, range)) {
        return registers + " overlap the string " +
               numbers(string.fact.first, drive::end_of(string.fact)) + " of " +
               in_quotes(profile.name);
      }
    }
  }
  if (profile.group_end(value.table, value.first) < value.end()) {
    return registers + " reach over the end of a parameter group of " + in_quotes(profile.name);
  }
  if (profile.is_special(range)) {
    return registers +
           " hold a stop, an opcode or its parameters, or a write that is guarded or never "
           "answered, of " +
           in_quotes(profile.name);
  }
  if (value.table == Table::holding_registers && profile.limits.write_registers < value.registers) {
    return registers + " cannot be written at once: " + in_quotes(profile.name) +
           " takes at most " + std::to_string(profile.limits.write_registers);
  }
  if (profile.limits.read_from(value.table) < value.registers) {
    return registers + " cannot be read at once: " + in_quotes(profile.name) + " reads at most " +
           std::to_string(profile.limits.read_from(value.table));
  }
  return {};
}

/// An address, or a range of consecutive values.
std::optional<IntegerRange> parse_element(const TomlValue& element, std::uint8_t registers) {
  constexpr std::int64_t kLast = 0xFFFF;
  if (const auto* first = std::get_if<std::int64_t>(&element.data)) {
    return *first >= 0 && *first + registers - 1 <= kLast
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
    list.table->report_expected(list.key, element,
                                "the first register of a value, 0 to " + std::to_string(last) +
                                    ", or a range of whole values such as \"" +
                                    (list.registers == 2 ? "310-329" : "400-407") + "\"");
    return;
  }
  for (auto first = range->min; first < range->max; first += list.registers) {
    const Value value{list.of, static_cast<std::uint16_t>(first), list.registers, false};
    const auto why = refusal(value, file, device);
    if (!why.empty()) {
      list.table->document().error(element.position, std::string(list.key) + ": " + why);
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
