// SPDX-License-Identifier: Apache-2.0
// LRC of ASCII frames (Serial Line V1.02, 6.2.1): the two's complement of the sum of all bytes,
// carries dropped.
#pragma once

#include <cstdint>

#include "modbus/bytes.hpp"

namespace mbgate::modbus {

/// The LRC of `bytes`: the bytes that the characters stand for, not the characters. It is 0 for
/// bytes that end with their own LRC.
std::uint8_t lrc(Bytes bytes);

}  // namespace mbgate::modbus
