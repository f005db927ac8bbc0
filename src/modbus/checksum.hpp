// SPDX-License-Identifier: Apache-2.0
// CRC-16 of RTU frames (Serial Line V1.02, 6.2.2): polynomial 0xA001 reflected, initial value
// 0xFFFF.
#pragma once

#include <cstdint>

#include "modbus/bytes.hpp"

namespace mbgate::modbus {

/// The CRC of `bytes`. On the wire its low byte goes first.
std::uint16_t crc16(Bytes bytes);

// LRC of ASCII frames (Serial Line V1.02, 6.2.1): the two's complement of the sum of all bytes,
// carries dropped.

/// The LRC of `bytes`: the bytes that the characters stand for, not the characters. It is 0 for
/// bytes that end with their own LRC.
std::uint8_t lrc(Bytes bytes);

}  // namespace mbgate::modbus
