// SPDX-License-Identifier: Apache-2.0
// Units of a client, or addresses of a bus: one, or a range such as "1-32".
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "config/toml/toml_reader.hpp"

namespace mbgate::config {

/// Both ends included.
struct UnitRange {
  std::uint8_t first = 0;
  std::uint8_t last = 0;
  [[nodiscard]] int size() const { return last - first + 1; }
  [[nodiscard]] bool contains(unsigned unit) const { return unit >= first && unit <= last; }
  [[nodiscard]] bool overlaps(const UnitRange& other) const {
    return first <= other.last && other.first <= last;
  }
};

/// "310-329", whatever is counted; `limits` bounds both ends.
std::optional<IntegerRange> parse_range(std::string_view text, IntegerRange limits);

/// An integer, or a range in a string, within `limits`, which lie within 0 to 255.
std::optional<UnitRange> read_units(TomlTable& table, std::string_view key, IntegerRange limits);

}  // namespace mbgate::config
