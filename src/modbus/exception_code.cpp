// SPDX-License-Identifier: Apache-2.0
#include "modbus/exception_code.hpp"

#include <cstdio>

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
  char number[24];
  std::snprintf(number, sizeof number, "exception 0x%02X", code);
  std::string text = number;
  if (const auto name = exception_name(code); !name.empty()) {
    text.append(" (").append(name).append(")");
  }
  return text;
}

}  // namespace mbgate::modbus
