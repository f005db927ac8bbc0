// SPDX-License-Identifier: Apache-2.0
#include "ctl/request/command.hpp"

#include <fmt/core.h>

#include "modbus/make_request.hpp"

namespace mbgate::ctl {
namespace {

// Application Protocol V1.1b3: 6.1, 6.3, 6.11 and 6.12.
constexpr std::size_t kMostReadBits = 2000;
constexpr std::size_t kMostReadRegisters = 125;
constexpr std::size_t kMostWrittenBits = 1968;
constexpr std::size_t kMostWrittenRegisters = 123;
constexpr std::size_t kAddresses = 65536;
constexpr std::uint16_t kCoilOn = 0xFF00;

/// Nothing if `count` values fit into one request and into the table, else what is wrong.
std::optional<std::string> find_misfit(const Place& place, std::size_t count,
                                       std::size_t most_places) {
  const std::size_t most = most_places / width(place.type);
  if (count == 0 || count > most) {
    const bool of_text = place.type == ValueType::text;
    return fmt::format("{}{} do not fit into one request: 1 to {}{}", count,
                       of_text ? " registers" : " values", most,
                       of_text ? ", two characters each" : "");
  }
  if (const std::size_t end = place.address + count * width(place.type); end > kAddresses) {
    return fmt::format("the last value would end at address {}, beyond 65535", end - 1);
  }
  return std::nullopt;
}

modbus::Request write_coils(const WriteCommand& command) {
  const std::size_t count = command.values.size();
  if (count == 1 && !command.multiple) {
    return modbus::make_single_write(Table::coils, command.place.address,
                                     command.values.front() != 0 ? kCoilOn : std::uint16_t{0});
  }
  std::vector<std::uint8_t> bytes((count + 7) / 8);
  for (std::size_t at = 0; at < count; ++at) {
    if (command.values[at] != 0) {
      bytes[at / 8] = static_cast<std::uint8_t>(bytes[at / 8] | (1U << (at % 8)));
    }
  }
  return modbus::make_multiple_write(
      {Table::coils, command.place.address, static_cast<std::uint16_t>(count)}, bytes);
}

modbus::Request write_registers(const WriteCommand& command) {
  const auto registers = to_registers(command.place.type, command.place.order, command.values);
  if (registers.size() == 1 && !command.multiple) {
    return modbus::make_single_write(Table::holding_registers, command.place.address,
                                     registers.front());
  }
  std::vector<std::uint8_t> bytes(2 * registers.size());
  for (std::size_t at = 0; at < registers.size(); ++at) {
    modbus::store_be16(bytes, 2 * at, registers[at]);
  }
  return modbus::make_multiple_write({Table::holding_registers, command.place.address,
                                      static_cast<std::uint16_t>(registers.size())},
                                     bytes);
}

}  // namespace

Result<modbus::Request, std::string> make_request(const ReadCommand& command) {
  const bool bits = modbus::holds_bits(command.place.table);
  if (auto misfit =
          find_misfit(command.place, command.count, bits ? kMostReadBits : kMostReadRegisters)) {
    return *misfit;
  }
  return modbus::make_read({command.place.table, command.place.address,
                            static_cast<std::uint16_t>(command.count * width(command.place.type))});
}

Result<modbus::Request, std::string> make_request(const WriteCommand& command) {
  const bool bits = modbus::holds_bits(command.place.table);
  if (auto misfit = find_misfit(command.place, command.values.size(),
                                bits ? kMostWrittenBits : kMostWrittenRegisters)) {
    return *misfit;
  }
  return bits ? write_coils(command) : write_registers(command);
}

std::vector<std::uint64_t> response_values(const ReadCommand& command,
                                           const modbus::Pdu& response) {
  const auto data = response.bytes().subspan(2);  // after function and byte count
  if (!modbus::holds_bits(command.place.table)) {
    std::vector<std::uint16_t> registers;
    for (std::size_t at = 0; at + 1 < data.size(); at += 2) {
      registers.push_back(modbus::load_be16(data, at));
    }
    return to_values(command.place.type, command.place.order, registers);
  }
  std::vector<std::uint64_t> bits;
  bits.reserve(command.count);
  for (std::size_t at = 0; at < command.count; ++at) {
    bits.push_back((data[at / 8] >> (at % 8)) & 1U);
  }
  return bits;
}

}  // namespace mbgate::ctl
