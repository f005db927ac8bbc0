// SPDX-License-Identifier: Apache-2.0
// Classifies the bytes that were heard on an idle line.
#pragma once

#include <chrono>

#include "ctl/doctor/finding.hpp"
#include "ctl/serial/serial_port.hpp"
#include "modbus/bytes.hpp"

namespace mbgate::ctl {

struct IdleLine {
  std::vector<std::uint8_t> heard{};  ///< the first bytes; of a line full of noise not all
  std::size_t bytes = 0;              ///< all that came
  std::chrono::nanoseconds time{0};   ///< how long it was listened to
};

Finding idle_finding(const IdleLine& line, const LineMode& mode);

/// Are there frames of another client?
[[nodiscard]] bool is_of_another_client(const IdleLine& line);
/// May there be some, at whatever rate and parity? Whoever sends there now damages them.
[[nodiscard]] bool may_be_of_another_client(const IdleLine& line);

/// What to do where another client is heard.
inline constexpr const char* kOneClient =
    "an RS-485 line has one client: let the other one (a gateway, a PLC, a tool) connect to the "
    "gateway instead";

}  // namespace mbgate::ctl
