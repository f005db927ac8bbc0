// SPDX-License-Identifier: Apache-2.0
// The written values that an entry of a profile or a device matches; words and ranges that several
// files use.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "bus/settings.hpp"
#include "config/toml/toml_reader.hpp"
#include "drive/profile.hpp"
#include "drive/values.hpp"
#include "modbus/request.hpp"

namespace mbgate::config {

inline constexpr std::uint16_t kCoilOn = 0xFF00;

/// `mask` and `value` of an entry whose table is known; or `not`, where `or_not` allows it.
void read_written(TomlTable& entry, bool or_not, drive::WriteMatch& match);

/// The same of a guarded write whose range is known: one register or coil, or a value of 32 bits.
void read_written(TomlTable& entry, drive::GuardedWrite& guarded);

/// `parameters` of a stop whose table and address are known: how many registers right behind it may
/// be written together with it.
void read_parameters(TomlTable& entry, drive::WriteMatch& match);

// Words that are used in more than one kind of file.

inline constexpr IntegerRange kRegisterValues = {0, 0xFFFF};
inline constexpr IntegerRange kRegisterAddresses = {0, 0xFFFF};

inline constexpr std::array kTables = {Word{"coils", modbus::Table::coils},
                                       Word{"discrete", modbus::Table::discrete_inputs},
                                       Word{"input", modbus::Table::input_registers},
                                       Word{"holding", modbus::Table::holding_registers}};
/// Tables that can be written.
inline constexpr std::array kWritableTables = {Word{"coils", modbus::Table::coils},
                                               Word{"holding", modbus::Table::holding_registers}};
/// Tables of registers.
inline constexpr std::array kRegisterTables = {Word{"input", modbus::Table::input_registers},
                                               Word{"holding", modbus::Table::holding_registers}};
inline constexpr std::array kWordOrders = {Word{"big", drive::WordOrder::big},
                                           Word{"little", drive::WordOrder::little}};

inline constexpr std::array kParities = {Word{"none", modbus::Parity::none},
                                         Word{"even", modbus::Parity::even},
                                         Word{"odd", modbus::Parity::odd}};
inline constexpr std::array kFramings = {Word{"rtu", bus::Framing::rtu},
                                         Word{"ascii", bus::Framing::ascii},
                                         Word{"tcp", bus::Framing::tcp}};

/// Of `write_echo`: does the echo of a write carry what the device made of the value?
inline constexpr std::array kEchoes = {Word{"value", false}, Word{"address", true}};

/// "coils", "discrete", "input" or "holding".
constexpr std::string_view table_word(modbus::Table table) { return word_for(kTables, table); }

/// The address of a register or coil: decimal, or hexadecimal behind 0x; nothing if it is neither.
std::optional<std::uint16_t> parse_register_address(std::string_view text);

constexpr std::string_view order_word(drive::WordOrder order) {
  return order == drive::WordOrder::big ? "big" : "little";
}

// Units of a client, or addresses of a bus: one, or a range such as "1-32".

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
