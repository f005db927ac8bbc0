// SPDX-License-Identifier: Apache-2.0
// Requests made rather than received. The caller keeps quantities and addresses within the limits
// of the Application Protocol V1.1b3, section 6; register data are bytes, high byte first.
#pragma once

#include <span>

#include "modbus/request.hpp"

namespace mbgate::modbus {

/// 01 to 04, by the table.
Request make_read(const TableRange& range);
/// 05 (`value` is 0000 or FF00) or 06, by the table.
Request make_single_write(Table table, std::uint16_t address, std::uint16_t value);
/// 15 (bits packed as on the wire) or 16, by the table.
Request make_multiple_write(const TableRange& range, Bytes data);
/// 05 or 06 for one value, 15 or 16 for several, or if `multiple`. A coil is off where its value is
/// 0.
Request make_write(Table table, std::uint16_t first, std::span<const std::uint16_t> values,
                   bool multiple = false);
/// 23.
Request make_read_write(const TableRange& read, const TableRange& write, Bytes data);

}  // namespace mbgate::modbus
