// SPDX-License-Identifier: Apache-2.0
// Writes with a special meaning for a drive.
#pragma once

#include <optional>
#include <vector>

#include "drive/device.hpp"
#include "modbus/request.hpp"

namespace mbgate::routing {

/// Does the request read or write any value (32 or 64 bits), or a part of one?
bool touches_value(const drive::Device& device, const modbus::Request& request);

/// Does the range hold a part of a value at one of its ends?
bool cuts_value(const drive::Device& device, const modbus::TableRange& range);

/// Does the request write an opcode whose position parameter has an unknown word order, for a
/// client that sees values in the order `seen`? If the order is configured (`opcode_order`), the
/// position is certain when it is written together with its opcode.
bool has_uncertain_position(const drive::Device& device, drive::WordOrder seen,
                            const modbus::Request& request);

/// The registers that a 16 or 23 writes, in the drive's word order. Where the client's order `seen`
/// differs, values are exchanged, and so is the position of an opcode whose order is configured.
std::vector<std::uint8_t> data_in_order(const drive::Device& device,
                                        std::optional<drive::WordOrder> seen,
                                        const modbus::Request& request);

}  // namespace mbgate::routing
