// SPDX-License-Identifier: Apache-2.0
// The answer that a device could give to a request, with data of a script's choice.
#pragma once

#include <vector>

#include "fuzz/fuzz.hpp"
#include "modbus/request.hpp"

namespace mbgate::fuzz {

inline modbus::Pdu response_to(const modbus::Request& request, Script& script) {
  const std::uint8_t kind = script.byte();
  if (kind % 16 == 15) {
    return modbus::Pdu::exception(request.function(),
                                  static_cast<modbus::ExceptionCode>(script.byte()));
  }
  if (!request.reads() || request.function() == 0x18) {
    return modbus::echo_response(request);
  }
  const auto& range = request.reads()->range;
  const bool bits =
      range.table == modbus::Table::coils || range.table == modbus::Table::discrete_inputs;
  const std::size_t size = bits ? (range.count + 7U) / 8U : range.count * std::size_t{2};
  std::vector<std::uint8_t> bytes{request.function(), static_cast<std::uint8_t>(size)};
  for (std::size_t at = 0; at < size; ++at) {
    bytes.push_back(static_cast<std::uint8_t>(kind + at));
  }
  return *modbus::Pdu::from(bytes);
}

}  // namespace mbgate::fuzz
