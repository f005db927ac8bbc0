// SPDX-License-Identifier: Apache-2.0
// What must be written for a write to be meant, as the entries of profiles and of devices say it.
#pragma once

#include "config/toml/toml_reader.hpp"
#include "drive/write_match.hpp"

namespace mbgate::config {

inline constexpr std::uint16_t kCoilOn = 0xFF00;

/// `mask` and `value` of an entry whose table is known; or `not`, where `or_not` allows it.
void read_written(TomlTable& entry, bool or_not, drive::WriteMatch& match);

/// `parameters` of a stop whose place is known: registers right behind it that may be written along
/// with it.
void read_parameters(TomlTable& entry, drive::WriteMatch& match);

}  // namespace mbgate::config
