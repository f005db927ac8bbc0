// SPDX-License-Identifier: Apache-2.0
// How characters are sent on a serial line: rate, parity, stop bits. RTU, so always 8 data bits.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "modbus/result.hpp"
#include "modbus/rtu_timing.hpp"

namespace mbgate::ctl {

struct LineMode {
  modbus::Baud baud{9600};
  modbus::CharacterFormat format{};
  friend bool operator==(const LineMode&, const LineMode&) = default;
};

/// "9600 8E1"
std::string mode_text(const LineMode& mode);

/// "even", "none" or "odd", as a configuration has it.
std::string_view parity_word(modbus::Parity parity);

/// Every rate with every parity, in the order of the lists: "9600,19200", "even,none,odd" and "1",
/// "2" or "1,2". The stop bits are those without a parity: with one there is always 1. The error is
/// a full sentence.
Result<std::vector<LineMode>, std::string> parse_modes(std::string_view bauds,
                                                       std::string_view parities,
                                                       std::string_view stop_bits);

}  // namespace mbgate::ctl
