// SPDX-License-Identifier: Apache-2.0
#include "modbus/codes.hpp"

#include <fmt/core.h>

namespace mbgate::modbus {

std::string_view exception_name(std::uint8_t code) {
  switch (code) {
    case 0x01: return "illegal function";
    case 0x02: return "illegal data address";
    case 0x03: return "illegal data value";
    case 0x04: return "server device failure";
    case 0x05: return "acknowledge";
    case 0x06: return "server device busy";
    case 0x08: return "memory parity error";
    case 0x0A: return "gateway path unavailable";
    case 0x0B: return "gateway target device failed to respond";
    default: return {};
  }
}

std::string exception_text(std::uint8_t code) {
  const auto name = exception_name(code);
  return name.empty() ? fmt::format("exception 0x{:02X}", code)
                      : fmt::format("exception 0x{:02X} ({})", code, name);
}

}  // namespace mbgate::modbus
