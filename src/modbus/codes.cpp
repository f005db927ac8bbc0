// SPDX-License-Identifier: Apache-2.0

#include "modbus/codes.hpp"

#include <fmt/core.h>

namespace mbgate::modbus {

std::string_view function_name(std::uint8_t function) {
  switch (function) {
    case 0x01: return "read coils";
    case 0x02: return "read discrete inputs";
    case 0x03: return "read holding registers";
    case 0x04: return "read input registers";
    case 0x05: return "write single coil";
    case 0x06: return "write single register";
    case 0x07: return "read exception status";
    case 0x08: return "diagnostics";
    case 0x0B: return "get comm event counter";
    case 0x0C: return "get comm event log";
    case 0x0F: return "write multiple coils";
    case 0x10: return "write multiple registers";
    case 0x11: return "report server id";
    case 0x14: return "read file record";
    case 0x15: return "write file record";
    case 0x16: return "mask write register";
    case 0x17: return "read/write multiple registers";
    case 0x18: return "read fifo queue";
    case 0x2B: return "encapsulated interface";
    default: return {};
  }
}

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
