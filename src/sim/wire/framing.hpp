// SPDX-License-Identifier: Apache-2.0
// The two framings of an ADU on a serial line, RTU and ASCII, for a simulated bus.
#pragma once

#include "modbus/ascii.hpp"
#include "modbus/rtu.hpp"

namespace mbgate::sim {

enum class Framing : std::uint8_t { rtu, ascii };

/// Long enough for either: an ASCII frame is the longer one.
using FrameBytes = modbus::AsciiBytes;

FrameBytes encode_frame(Framing framing, std::uint8_t address, const modbus::Pdu& pdu);

/// The frame's parts; nothing if it is damaged.
std::optional<modbus::RtuAdu> decode_frame(Framing framing, modbus::Bytes frame);

/// Makes the CRC or LRC of a frame wrong and changes nothing else.
void spoil_check(Framing framing, FrameBytes& frame);

}  // namespace mbgate::sim
