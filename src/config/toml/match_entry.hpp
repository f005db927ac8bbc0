// SPDX-License-Identifier: Apache-2.0
// Which written values an entry of a profile or a device matches.
#pragma once

#include "config/toml/toml_reader.hpp"
#include "drive/profile.hpp"

namespace mbgate::config {

inline constexpr std::uint16_t kCoilOn = 0xFF00;

/// `mask` and `value` of an entry whose table is known; or `not`, where `or_not` allows it.
void read_written(TomlTable& entry, bool or_not, drive::WriteMatch& match);

/// The same of a guarded write whose range is known: one register or coil, or a value of 32 bits.
void read_written(TomlTable& entry, drive::GuardedWrite& guarded);

/// `parameters` of a stop whose table and address are known: how many registers right behind it may
/// be written together with it.
void read_parameters(TomlTable& entry, drive::WriteMatch& match);

}  // namespace mbgate::config
