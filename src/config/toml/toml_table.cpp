// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <fmt/core.h>

#include "base/text.hpp"
#include "config/toml/suggestion.hpp"
#include "config/toml/toml_reader.hpp"
#include "config/toml/toml_value.hpp"

namespace mbgate::config {
namespace {

template <typename Table>
auto find_entry(Table& table, std::string_view key) {
  const auto entry = std::ranges::find(table.entries, key, &TomlEntry::key);
  return entry == table.entries.end() ? nullptr : &*entry;
}

std::string_view whole_steps(std::chrono::nanoseconds step) {
  return step == std::chrono::seconds(1) ? "whole seconds" : "whole milliseconds";
}

/// What stands in the header of a table at `key`: "device.stops" within "[[device]]".
std::string path_of(std::string_view title, std::string_view key) {
  const auto first = title.find_first_not_of('[');
  if (first == std::string_view::npos) {
    return std::string(key);
  }
  const auto end = title.find(']');
  return fmt::format("{}.{}", title.substr(first, end - first), key);
}

/// Is it the text of an integer in the range, of which only the quotes are wrong?
bool is_quoted_number(const TomlValue& value, IntegerRange range) {
  const auto* text = std::get_if<std::string>(&value.data);
  const auto number = text != nullptr ? integer_in<std::int64_t>(*text) : std::nullopt;
  return number && *number >= range.min && *number <= range.max;
}

bool is_quoted_truth(const TomlValue& value) {
  const auto* text = std::get_if<std::string>(&value.data);
  return text != nullptr && (*text == "true" || *text == "false");
}

/// What stands between the quotes is right.
std::string without_quotes(const TomlValue& value) {
  return std::get<std::string>(value.data) + " without quotes";
}

bool is_number(const TomlValue& value) {
  return std::holds_alternative<std::int64_t>(value.data) ||
         std::holds_alternative<double>(value.data);
}

}  // namespace

std::string range_text(const IntegerRange& range) {
  return fmt::format("an integer from {} to {}", range.min, range.max);
}

std::string range_text(const DurationRange& range) {
  return fmt::format("{}a duration from {} to {}", range.zero_is_off ? "\"0s\" (off) or " : "",
                     to_text(range.min), to_text(range.max));
}

Position TomlTable::position() const { return node_->position; }
const std::string& TomlTable::title() const { return node_->title; }

const TomlValue* TomlTable::value(std::string_view key) {
  if (std::ranges::find(node_->known, key) == node_->known.end()) {
    node_->known.emplace_back(key);
  }
  const auto* entry = find_entry(*node_, key);
  return entry == nullptr ? nullptr : &entry->value;
}

bool TomlTable::has(std::string_view key) { return value(key) != nullptr; }

bool TomlTable::require(std::string_view key) {
  if (has(key)) {
    return true;
  }
  document_->error(position(), "{}the key '{}' is missing", title().empty() ? "" : title() + ": ",
                   key);
  return false;
}

void TomlTable::require_all(std::initializer_list<const char*> keys) {
  std::ranges::for_each(keys, [this](const auto* key) { require(key); });
}

void TomlTable::reject(std::initializer_list<const char*> keys, std::string_view message) {
  for (const auto* key : keys) {
    if (has(key)) {
      error(key, message);
    }
  }
}

void TomlTable::accept(std::initializer_list<const char*> keys) {
  std::ranges::for_each(keys, [this](const auto* key) { has(key); });
}

Position TomlTable::value_position(std::string_view key) const {
  const auto* entry = find_entry(*node_, key);
  return entry == nullptr ? position() : entry->value.position;
}

std::string TomlTable::place_of(std::string_view key) const {
  return place(*document_, value_position(key));
}

void TomlTable::error(std::string_view key, std::string_view message) {
  document_->error(value_position(key), "{}: {}", key, message);
}

void TomlTable::warning(std::string_view key, std::string_view message) {
  document_->warning(value_position(key), fmt::format("{}: {}", key, message));
}

void TomlTable::report_expected(std::string_view key, const TomlValue& found,
                                std::string_view expected) {
  document_->error(found.position, "{}: expected {}, found {}", key, expected, describe(found));
}

std::optional<std::string> TomlTable::string(std::string_view key) {
  const auto* found = value(key);
  if (found == nullptr) {
    return std::nullopt;
  }
  if (const auto* text = std::get_if<std::string>(&found->data)) {
    return *text;
  }
  report_expected(key, *found, "a string");
  return std::nullopt;
}

std::optional<bool> TomlTable::boolean(std::string_view key) {
  const auto* found = value(key);
  if (found == nullptr) {
    return std::nullopt;
  }
  if (const auto* truth = std::get_if<bool>(&found->data)) {
    return *truth;
  }
  report_expected(key, *found, is_quoted_truth(*found) ? without_quotes(*found) : "true or false");
  return std::nullopt;
}

std::optional<std::int64_t> TomlTable::integer(std::string_view key, IntegerRange range) {
  const auto* found = value(key);
  if (found == nullptr) {
    return std::nullopt;
  }
  const auto* number = std::get_if<std::int64_t>(&found->data);
  if (number != nullptr && *number >= range.min && *number <= range.max) {
    return *number;
  }
  report_expected(key, *found,
                  is_quoted_number(*found, range) ? without_quotes(*found) : range_text(range));
  return std::nullopt;
}

std::optional<std::chrono::nanoseconds> TomlTable::duration(std::string_view key,
                                                            DurationRange range) {
  const auto* found = value(key);
  if (found == nullptr) {
    return std::nullopt;
  }
  const auto* text = std::get_if<std::string>(&found->data);
  if (text == nullptr) {
    report_expected(key, *found,
                    is_number(*found)
                        ? "a duration in quotes with its unit (us, ms, s, m, h), such as \"300ms\""
                        : "a duration, such as \"300ms\"");
    return std::nullopt;
  }
  const auto duration = parse_duration(*text);
  if (!duration) {
    report_expected(key, *found, "a number with its unit (us, ms, s, m, h), such as \"300ms\"");
    return std::nullopt;
  }
  const bool off = range.zero_is_off && duration->count() == 0;
  if (!off && (*duration < range.min || *duration > range.max)) {
    report_expected(key, *found, range_text(range));
    return std::nullopt;
  }
  if (range.step.count() != 0 && duration->count() % range.step.count() != 0) {
    report_expected(key, *found, whole_steps(range.step));
    return std::nullopt;
  }
  return duration;
}

const std::vector<TomlValue>* TomlTable::list(std::string_view key) {
  const auto* found = value(key);
  if (found == nullptr) {
    return nullptr;
  }
  const auto* elements = std::get_if<std::vector<TomlValue>>(&found->data);
  if (elements == nullptr) {
    report_expected(key, *found, "a list in square brackets");
  }
  return elements;
}

std::optional<std::vector<TomlText>> TomlTable::strings(std::string_view key) {
  const auto* elements = list(key);
  if (elements == nullptr) {
    return std::nullopt;
  }
  std::vector<TomlText> texts;
  for (const auto& element : *elements) {
    if (const auto* text = std::get_if<std::string>(&element.data)) {
      texts.push_back({*text, element.position});
    } else {
      report_expected(key, element, "a string");
    }
  }
  return texts;
}

std::optional<std::size_t> TomlTable::word_index(std::string_view key,
                                                 const std::vector<std::string_view>& words) {
  const auto* found = value(key);
  if (found == nullptr) {
    return std::nullopt;
  }
  const auto* text = std::get_if<std::string>(&found->data);
  if (text != nullptr) {
    const auto word = std::ranges::find(words, *text);
    if (word != words.end()) {
      return static_cast<std::size_t>(word - words.begin());
    }
  }
  std::string expected;
  for (const auto word : words) {
    const bool last = word == words.back();
    expected += expected.empty() ? "" : last ? " or " : ", ";
    expected += in_quotes(word);
  }
  document_->error(found->position, "{}: expected {}, found {}{}", key, expected, describe(*found),
                   text == nullptr ? "" : did_you_mean(*text, words));
  return std::nullopt;
}

std::optional<TomlTable> TomlTable::table(std::string_view key) {
  value(key);
  auto* entry = find_entry(*node_, key);
  if (entry == nullptr) {
    return std::nullopt;
  }
  if (auto* inner = std::get_if<TomlTableValue>(&entry->value.data)) {
    return TomlTable(*document_, *inner);
  }
  report_expected(key, entry->value, fmt::format("the table [{}]", path_of(title(), key)));
  return std::nullopt;
}

std::vector<TomlTable> TomlTable::tables(std::string_view key) {
  value(key);
  std::vector<TomlTable> tables;
  auto* entry = find_entry(*node_, key);
  if (entry == nullptr) {
    return tables;
  }
  const std::string expected = fmt::format("tables headed [[{}]]", path_of(title(), key));
  auto* elements = std::get_if<std::vector<TomlValue>>(&entry->value.data);
  if (elements == nullptr) {
    report_expected(key, entry->value, expected);
    return tables;
  }
  for (auto& element : *elements) {
    if (auto* inner = std::get_if<TomlTableValue>(&element.data)) {
      tables.push_back(TomlTable(*document_, *inner));
    } else {
      report_expected(key, element, expected);
    }
  }
  return tables;
}

}  // namespace mbgate::config
