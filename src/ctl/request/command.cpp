// SPDX-License-Identifier: Apache-2.0
#include "ctl/request/command.hpp"

#include <fmt/core.h>

#include "drive/profile.hpp"
#include "modbus/request.hpp"

namespace mbgate::ctl {
namespace {

constexpr std::size_t kAddresses = 65536;

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

}  // namespace

Result<modbus::Request, std::string> make_request(const ReadCommand& command) {
  if (auto misfit = find_misfit(command.place, command.count,
                                drive::Limits().read_from(command.place.table))) {
    return *misfit;
  }
  return modbus::make_read({command.place.table, command.place.address,
                            static_cast<std::uint16_t>(command.count * width(command.place.type))});
}

Result<modbus::Request, std::string> make_request(const WriteCommand& command) {
  const Place& place = command.place;
  if (auto misfit =
          find_misfit(place, command.values.size(), drive::Limits().written_to(place.table))) {
    return *misfit;
  }
  return modbus::make_write(place.table, place.address,
                            to_registers(place.type, place.order, command.values),
                            command.multiple);
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
