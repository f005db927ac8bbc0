// SPDX-License-Identifier: Apache-2.0
// A device as its client sees it through windows and in its own word order: register by register,
// and never by whole requests, as the product does it. What is written through the view is written
// to the device, what is read is the device's.
#pragma once

#include <optional>
#include <vector>

#include "fuzz/plain_device.hpp"
#include "routing/route.hpp"

namespace mbgate::fuzz {

/// What a client asks of one table.
struct Asked {
  Table table;
  std::uint32_t first;
  std::uint32_t count;
  [[nodiscard]] std::uint32_t end() const { return first + count; }
};

class ClientView {
 public:
  ClientView(const std::vector<routing::AddressWindow>& windows,
             const std::vector<drive::Value>& values, bool one_memory, bool mirrored)
      : windows_(windows), values_(values), one_memory_(one_memory), mirrored_(mirrored) {}

  /// The window that holds all that the client asks for.
  [[nodiscard]] const routing::AddressWindow* window_of(const Asked& asked) const {
    for (const auto& window : windows_) {
      if (window.table == asked.table && asked.first >= window.from &&
          asked.end() <= window.from + window.count) {
        return &window;
      }
    }
    return nullptr;
  }
  /// Where the drive has all that the client asks for; nothing if no window holds it.
  [[nodiscard]] std::optional<Asked> moved(const Asked& asked) const {
    const auto* window = window_of(asked);
    if (window != nullptr) {
      return Asked{window->to_table, asked.first - window->from + window->to, asked.count};
    }
    return windows_.empty() ? std::optional(asked) : std::nullopt;
  }
  /// The value that a register of the drive belongs to.
  [[nodiscard]] const drive::Value* value_at(Table table, std::uint32_t address) const {
    const Table real =
        one_memory_ && table == Table::input_registers ? Table::holding_registers : table;
    for (const drive::Value& value : values_) {
      if (value.table == real && address >= value.first &&
          address < std::uint32_t{value.first} + value.registers) {
        return &value;
      }
    }
    return nullptr;
  }
  /// The register of the drive that holds what the client sees at this place.
  [[nodiscard]] std::uint32_t place(Table table, std::uint32_t address) const {
    const drive::Value* value = mirrored_ ? value_at(table, address) : nullptr;
    return value == nullptr
               ? address
               : std::uint32_t{value->first} + (value->registers - 1U) - (address - value->first);
  }

  /// What the client's request, which no window refuses, does to the device and gets.
  std::vector<std::uint8_t> carry_out(PlainDevice& device, modbus::Bytes pdu) const {
    const std::uint8_t function = pdu[0];
    const std::uint32_t first = PlainDevice::word(pdu, 1);
    const std::uint16_t second = PlainDevice::word(pdu, 3);
    const std::vector<std::uint8_t> repeated(pdu.begin(), pdu.begin() + 5);
    const auto put = [&](Table table, std::uint32_t address, std::uint32_t count, std::uint32_t at,
                         std::uint16_t value) {
      const Asked there = *moved({table, address, count});
      device.write(there.table, place(there.table, there.first + at), value);
    };
    switch (function) {
      case 0x05: put(Table::coils, first, 1, 0, second == 0 ? 0 : 1); return repeated;
      case 0x06: put(Table::holding_registers, first, 1, 0, second); return repeated;
      case 0x0F:
        for (std::uint32_t at = 0; at < second; ++at) {
          put(Table::coils, first, second, at, (pdu[6 + at / 8] >> (at % 8)) & 1U);
        }
        return repeated;
      case 0x10:
        for (std::uint32_t at = 0; at < second; ++at) {
          put(Table::holding_registers, first, second, at,
              PlainDevice::word(pdu, 6 + std::size_t{at} * 2));
        }
        return repeated;
      case 0x16: {
        const unsigned old = seen(device, {Table::holding_registers, first, 1}, 0);
        const unsigned or_mask = PlainDevice::word(pdu, 5);
        put(Table::holding_registers, first, 1, 0,
            static_cast<std::uint16_t>((old & second) | (or_mask & ~unsigned{second})));
        return {pdu.begin(), pdu.end()};
      }
      case 0x17:
        for (std::uint32_t at = 0; at < PlainDevice::word(pdu, 7); ++at) {
          put(Table::holding_registers, PlainDevice::word(pdu, 5), PlainDevice::word(pdu, 7), at,
              PlainDevice::word(pdu, 10 + std::size_t{at} * 2));
        }
        return registers(device, function, {Table::holding_registers, first, second});
      case 0x01: return bits(device, function, {Table::coils, first, second});
      case 0x02: return bits(device, function, {Table::discrete_inputs, first, second});
      case 0x03: return registers(device, function, {Table::holding_registers, first, second});
      default: return registers(device, function, {Table::input_registers, first, second});
    }
  }

 private:
  [[nodiscard]] std::uint16_t seen(const PlainDevice& device, const Asked& asked,
                                   std::uint32_t at) const {
    const Asked there = *moved(asked);
    return device.at(there.table, place(there.table, there.first + at));
  }
  [[nodiscard]] std::vector<std::uint8_t> registers(const PlainDevice& device,
                                                    std::uint8_t function,
                                                    const Asked& asked) const {
    std::vector<std::uint8_t> answer{function, static_cast<std::uint8_t>(asked.count * 2)};
    for (std::uint32_t at = 0; at < asked.count; ++at) {
      answer.push_back(static_cast<std::uint8_t>(seen(device, asked, at) / 256U));
      answer.push_back(static_cast<std::uint8_t>(seen(device, asked, at) % 256U));
    }
    return answer;
  }
  [[nodiscard]] std::vector<std::uint8_t> bits(const PlainDevice& device, std::uint8_t function,
                                               const Asked& asked) const {
    std::vector<std::uint8_t> answer(2 + (asked.count + 7) / 8);
    answer[0] = function;
    answer[1] = static_cast<std::uint8_t>(answer.size() - 2);
    for (std::uint32_t bit = 0; bit < asked.count; ++bit) {
      answer[2 + bit / 8] |= static_cast<std::uint8_t>(seen(device, asked, bit) << (bit % 8));
    }
    return answer;
  }

  std::vector<routing::AddressWindow> windows_;
  std::vector<drive::Value> values_;
  bool one_memory_;
  bool mirrored_;
};

}  // namespace mbgate::fuzz
