// SPDX-License-Identifier: Apache-2.0
// LRC of ASCII frames (Serial Line V1.02, 6.2.1): the two's complement of the sum of all bytes,
// carries dropped.
#pragma once

#include <cstdint>

#include "modbus/bytes.hpp"

namespace mbgate::modbus {

/// The LRC of `bytes`, which are those that the characters stand for. Of bytes that end with their
/// own LRC it is 0.
std::uint8_t lrc(Bytes bytes);

}  // namespace mbgate::modbus
