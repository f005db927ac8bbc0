// SPDX-License-Identifier: Apache-2.0
#include "config/keys/plain_key.hpp"

namespace mbgate::config {
namespace {

template <typename Value>
KeyValue value_or_nothing(const std::optional<Value>& value) {
  return value ? KeyValue(*value) : KeyValue();
}

}  // namespace

KeyValue read_key(TomlTable& table, std::string_view key, const KeyRange& range) {
  if (const auto* integers = std::get_if<IntegerRange>(&range)) {
    return value_or_nothing(table.integer(key, *integers));
  }
  if (const auto* durations = std::get_if<DurationRange>(&range)) {
    return value_or_nothing(table.duration(key, *durations));
  }
  return value_or_nothing(table.boolean(key));
}

}  // namespace mbgate::config
