// SPDX-License-Identifier: Apache-2.0
// Answers requests that read or write a register bank, by the rules of a drive: how many registers
// at once, and which exception for which refusal. The drive itself carries out what a write
// commands.
#pragma once

#include <initializer_list>
#include <optional>

#include "modbus/pdu.hpp"
#include "modbus/request.hpp"
#include "modbus/rtu_timing.hpp"
#include "sim/drives/register_bank.hpp"

namespace mbgate::sim {

using modbus::Duration;

/// What a drive does about a request that it has received.
struct Reaction {
  std::optional<modbus::Pdu> response;  ///< nothing: the drive does not answer
  Duration delay{0};                    ///< what the work takes, besides the usual processing time
  Duration deaf_for{0};                 ///< it restarts and receives nothing for this long
  Duration busy_for{
      0};  ///< after this answer it refuses everything with exception 06 for this long
};

/// May also be a maker's own code, which modbus::ExceptionCode does not name.
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

/// A request of one of the `functions` that the drive has; else the exception that it answers,
/// which is `refusal` for another function.
Result<modbus::Request, Reaction> request_of(const modbus::Pdu& pdu,
                                             std::initializer_list<std::uint8_t> functions,
                                             ExceptionByte refusal = 0x01);

/// Answers functions 01 to 04 from `bank`. The request must have reads().
modbus::Pdu serve_read(const modbus::Request& request, const RegisterBank& bank,
                       const RegisterRules& rules);

/// Carries out functions 05, 06 and 16 on `bank`; an exception means that nothing was written. The
/// request must have writes().
modbus::Pdu serve_write(const modbus::Request& request, RegisterBank& bank,
                        const RegisterRules& rules);

/// The registers that functions 05, 06 and 16 write; a coil is 0 or 1.
Registers written_words(const modbus::Request& request);

/// Does the range include the register?
inline bool touches(const modbus::TableRange& range, std::uint16_t address) {
  return address >= range.first && address - range.first < range.count;
}

}  // namespace mbgate::sim
