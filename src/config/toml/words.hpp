// SPDX-License-Identifier: Apache-2.0
// Words that are used in more than one kind of file.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "config/toml/toml_reader.hpp"
#include "drive/word_order.hpp"
#include "modbus/request.hpp"

namespace mbgate::config {

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

/// "coils", "discrete", "input" or "holding".
constexpr std::string_view table_word(modbus::Table table) {
  for (const auto& word : kTables) {
    if (word.value == table) {
      return word.text;
    }
  }
  return {};
}

/// The address of a register or coil: decimal, or hexadecimal behind 0x; nothing if it is neither.
std::optional<std::uint16_t> parse_register_address(std::string_view text);

constexpr std::string_view order_word(drive::WordOrder order) {
  return order == drive::WordOrder::big ? "big" : "little";
}

}  // namespace mbgate::config
