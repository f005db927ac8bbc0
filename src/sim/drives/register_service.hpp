// SPDX-License-Identifier: Apache-2.0
// Requests that read or write a register bank, answered by the rules of a drive: how many at once,
// and which exception stands for which refusal. What a write sets in motion is the business of the
// drive.
#pragma once

#include "modbus/request.hpp"
#include "sim/drives/reaction.hpp"
#include "sim/drives/register_bank.hpp"

namespace mbgate::sim {

/// Codes of makers included, which modbus::ExceptionCode does not name.
using ExceptionByte = std::uint8_t;

struct RegisterRules {
  std::uint16_t most_read;
  std::uint16_t most_written;
  ExceptionByte no_such_register = 0x02;
  ExceptionByte not_readable = 0x02;
  ExceptionByte not_writable = 0x02;
  ExceptionByte out_of_range = 0x03;
  ExceptionByte too_many = 0x03;
};

ExceptionByte code_of(Refusal refusal, const RegisterRules& rules);

modbus::Pdu exception(std::uint8_t function, ExceptionByte code);

/// Functions 01 to 04 out of `bank`. The request must have reads().
modbus::Pdu serve_read(const modbus::Request& request, const RegisterBank& bank,
                       const RegisterRules& rules);

/// Functions 05, 06 and 16 into `bank`; an exception means that nothing was written. The request
/// must have writes().
modbus::Pdu serve_write(const modbus::Request& request, RegisterBank& bank,
                        const RegisterRules& rules);

/// The registers that functions 05, 06 and 16 write; a coil is 0 or 1.
Registers written_words(const modbus::Request& request);

/// Does the range hold the register?
inline bool touches(const modbus::TableRange& range, std::uint16_t address) {
  return address >= range.first && address - range.first < range.count;
}

}  // namespace mbgate::sim
