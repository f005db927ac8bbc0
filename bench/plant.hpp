// SPDX-License-Identifier: Apache-2.0
// What the harness simulates: buses with devices whose registers are a function of their place, and
// the time that a transaction takes on the wire at the least.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "samples.hpp"

namespace mbgate::bench {

/// RTU frames, 8N1: ten bits a character, since a pty keeps no parity.
struct Plant {
  unsigned baud = 115200;  ///< 0: not paced, bytes take no time and no silence is asked for
  unsigned buses = 1;
  unsigned devices = 4;     ///< on each bus, at the addresses from 1 on
  unsigned dead = 0;        ///< so many of them, the last ones, never answer
  unsigned registers = 10;  ///< that each request reads

  [[nodiscard]] bool paced() const { return baud != 0; }
  [[nodiscard]] bool answers(unsigned address) const {
    return address >= 1 && address <= devices - dead;
  }
  /// The time of so many characters on the wire.
  [[nodiscard]] Nanoseconds characters(std::size_t count) const;
  /// 3.5 characters up to 19200 baud, 1.75 ms above (Modbus over Serial Line 1.02, 2.5.1.1).
  [[nodiscard]] Nanoseconds t3_5() const;
  /// The least that a transaction takes: request, t3.5 until the device answers, response, t3.5.
  [[nodiscard]] Nanoseconds exchange() const;
};

constexpr std::size_t kRequestSize = 8;  ///< address, function, first register, count, CRC
constexpr std::size_t response_size(unsigned registers) { return 5 + 2 * std::size_t{registers}; }

/// What register `number` of a device holds: another value at every place, so that an answer from
/// another bus, device or register is seen.
std::uint16_t register_value(unsigned bus, unsigned address, unsigned number);

using Frame = std::vector<std::uint8_t>;
/// Function 03 in RTU.
Frame make_request(unsigned address, unsigned first, unsigned registers);
/// The answer to a request of function 03 in RTU, CRC included; empty if it is none that the
/// plant's devices answer.
Frame answer(unsigned bus, const Frame& request);

}  // namespace mbgate::bench
