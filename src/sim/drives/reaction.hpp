// SPDX-License-Identifier: Apache-2.0
// What a drive does about a request that it has received.
#pragma once

#include <optional>

#include "modbus/pdu.hpp"
#include "modbus/rtu_timing.hpp"

namespace mbgate::sim {

using modbus::Duration;

struct Reaction {
  std::optional<modbus::Pdu> response;  ///< nothing: the drive does not answer
  Duration delay{0};                    ///< what the work takes, besides the usual processing time
  Duration deaf_for{0};                 ///< it restarts and receives nothing for this long
  Duration busy_for{
      0};  ///< after this answer it refuses everything with exception 06 for this long
};

}  // namespace mbgate::sim
