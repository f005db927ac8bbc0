// SPDX-License-Identifier: Apache-2.0
// A device that does what a request says, at once and without limits, and counts what was written.
// It reads the bytes by itself, so that it is a witness of what the product makes of them.
#pragma once

#include <map>
#include <set>
#include <utility>
#include <vector>

#include "fuzz/fuzz.hpp"
#include "modbus/request.hpp"

namespace mbgate::fuzz {

using modbus::Table;

/// A register, or a bit as 0 or 1.
using Cell = std::pair<Table, std::uint32_t>;

class PlainDevice {
 public:
  /// `one_memory`: function 04 reads the registers that 03 reads.
  explicit PlainDevice(bool one_memory = false) : one_memory_(one_memory) {}

  [[nodiscard]] std::uint16_t at(Table table, std::uint32_t address) const {
    const Cell cell = cell_at(table, address);
    const auto found = cells_.find(cell);
    return found == cells_.end() ? untouched(cell) : found->second;
  }
  void write(Table table, std::uint32_t address, std::uint16_t value) {
    const Cell cell = cell_at(table, address);
    cells_[cell] = value;
    written_.insert(cell);
  }
  /// What was written, and in how many goes.
  [[nodiscard]] const std::map<Cell, std::uint16_t>& cells() const { return cells_; }
  [[nodiscard]] const std::multiset<Cell>& written() const { return written_; }

  /// The response to a well-formed request of functions 01 to 06, 15, 16, 22 and 23 (Application
  /// Protocol V1.1b3, section 6).
  std::vector<std::uint8_t> carry_out(modbus::Bytes pdu) {
    const std::uint8_t function = pdu[0];
    const std::uint16_t first = word(pdu, 1);
    const std::uint16_t second = word(pdu, 3);
    const std::vector<std::uint8_t> repeated(pdu.begin(), pdu.begin() + 5);
    switch (function) {
      case 0x05: write(Table::coils, first, second == 0 ? 0 : 1); return repeated;
      case 0x06: write(Table::holding_registers, first, second); return repeated;
      case 0x0F:
        for (std::uint32_t at = 0; at < second; ++at) {
          write(Table::coils, first + at, (pdu[6 + at / 8] >> (at % 8)) & 1U);
        }
        return repeated;
      case 0x10: write_registers(first, second, pdu.subspan(6)); return repeated;
      case 0x16: {
        const unsigned old = at(Table::holding_registers, first);
        const unsigned or_mask = word(pdu, 5);
        write(Table::holding_registers, first,
              static_cast<std::uint16_t>((old & second) | (or_mask & ~unsigned{second})));
        return {pdu.begin(), pdu.end()};
      }
      case 0x17:
        write_registers(word(pdu, 5), word(pdu, 7), pdu.subspan(10));
        return registers(function, Table::holding_registers, first, second);
      case 0x01: return bits(function, Table::coils, first, second);
      case 0x02: return bits(function, Table::discrete_inputs, first, second);
      case 0x03: return registers(function, Table::holding_registers, first, second);
      default: return registers(function, Table::input_registers, first, second);
    }
  }

  static std::uint16_t word(modbus::Bytes bytes, std::size_t at) {
    return static_cast<std::uint16_t>(bytes[at] * 256U + bytes[at + 1]);
  }

 private:
  [[nodiscard]] Cell cell_at(Table table, std::uint32_t address) const {
    require(address < 0x10000, "no address is beyond a table");
    const bool moved = one_memory_ && table == Table::input_registers;
    return {moved ? Table::holding_registers : table, address};
  }
  /// Something else in each register.
  static std::uint16_t untouched(const Cell& cell) {
    const bool is_bit = cell.first == Table::coils || cell.first == Table::discrete_inputs;
    const std::uint32_t mixed = cell.second * 40503U + static_cast<std::uint32_t>(cell.first) * 77U;
    return static_cast<std::uint16_t>(is_bit ? (mixed >> 7U) & 1U : mixed & 0xFFFFU);
  }
  void write_registers(std::uint32_t first, std::uint32_t count, modbus::Bytes data) {
    for (std::uint32_t at = 0; at < count; ++at) {
      write(Table::holding_registers, first + at, word(data, std::size_t{at} * 2));
    }
  }
  [[nodiscard]] std::vector<std::uint8_t> registers(std::uint8_t function, Table table,
                                                    std::uint32_t first,
                                                    std::uint32_t count) const {
    std::vector<std::uint8_t> answer{function, static_cast<std::uint8_t>(count * 2)};
    for (std::uint32_t address = first; address < first + count; ++address) {
      answer.push_back(static_cast<std::uint8_t>(at(table, address) / 256U));
      answer.push_back(static_cast<std::uint8_t>(at(table, address) % 256U));
    }
    return answer;
  }
  [[nodiscard]] std::vector<std::uint8_t> bits(std::uint8_t function, Table table,
                                               std::uint32_t first, std::uint32_t count) const {
    std::vector<std::uint8_t> answer(2 + (count + 7) / 8);
    answer[0] = function;
    answer[1] = static_cast<std::uint8_t>(answer.size() - 2);
    for (std::uint32_t bit = 0; bit < count; ++bit) {
      answer[2 + bit / 8] |= static_cast<std::uint8_t>(at(table, first + bit) << (bit % 8));
    }
    return answer;
  }

  bool one_memory_;
  std::map<Cell, std::uint16_t> cells_;  ///< that were written
  std::multiset<Cell> written_;
};

}  // namespace mbgate::fuzz
