// SPDX-License-Identifier: Apache-2.0
// One readable line for any ADU, for traces, demonstrations and error texts. Accepts any bytes.
#pragma once

#include <string>
#include <string_view>

#include "modbus/frames.hpp"
#include "modbus/request.hpp"

namespace mbgate::modbus {

/// "holding registers"
std::string_view table_name(Table table);

/// "30..31", of one address "30".
std::string addresses_text(const TableRange& range);

/// "01 03 00 1E": upper-case hexadecimal bytes.
std::string hex(Bytes bytes);

/// "read holding registers 30..31", "write single register 124 = 0x00E1", "function 70, 4 bytes".
std::string describe_request(Bytes pdu);

/// "2 registers: 0x0003 0x0D40", "exception 0x02 (illegal data address)".
std::string describe_response(Bytes pdu);

enum class Direction : std::uint8_t { request, response };

/// "unit 1: read holding registers 30..31", of a frame of a serial line.
std::string describe_adu(const RtuAdu& adu, Direction direction);

/// The same, or what is wrong with the frame.
std::string describe_rtu(Bytes frame, Direction direction);

/// "transaction 7 unit 1: read holding registers 30..31", or what is wrong with the ADU.
std::string describe_mbap(Bytes adu, Direction direction);

}  // namespace mbgate::modbus
