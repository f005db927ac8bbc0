// SPDX-License-Identifier: Apache-2.0
#include "ctl/request/value.hpp"

namespace mbgate::ctl {
namespace {

/// How far up in its value a register is, in bits; `at` counts the registers of the value.
std::size_t shift_of(std::size_t at, ValueType type, drive::WordOrder order) {
  return 16 * (order == drive::WordOrder::big ? width(type) - 1 - at : at);
}

}  // namespace

std::vector<std::uint16_t> to_registers(ValueType type, drive::WordOrder order,
                                        std::span<const std::uint64_t> values) {
  std::vector<std::uint16_t> registers;
  registers.reserve(values.size() * width(type));
  for (const std::uint64_t bits : values) {
    for (std::size_t at = 0; at < width(type); ++at) {
      registers.push_back(static_cast<std::uint16_t>(bits >> shift_of(at, type, order)));
    }
  }
  return registers;
}

std::vector<std::uint64_t> to_values(ValueType type, drive::WordOrder order,
                                     std::span<const std::uint16_t> registers) {
  std::vector<std::uint64_t> values;
  values.reserve(registers.size() / width(type));
  for (std::size_t first = 0; first + width(type) <= registers.size(); first += width(type)) {
    std::uint64_t bits = 0;
    for (std::size_t at = 0; at < width(type); ++at) {
      bits |= std::uint64_t{registers[first + at]} << shift_of(at, type, order);
    }
    values.push_back(bits);
  }
  return values;
}

}  // namespace mbgate::ctl
