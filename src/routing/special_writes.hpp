// SPDX-License-Identifier: Apache-2.0
// Writes that mean more to a drive than a number in a register.
#pragma once

#include <optional>
#include <vector>

#include "drive/device.hpp"
#include "modbus/request.hpp"

namespace mbgate::routing {

/// Are values among what the request reads or writes?
bool touches_value(const drive::Device& device, const modbus::Request& request);

/// Does it write an opcode whose position parameter has no certain order for a client that sees
/// values in the order `seen`? Where the user has stated the order, a position that comes with its
/// opcode is certain.
bool has_uncertain_position(const drive::Device& device, drive::WordOrder seen,
                            const modbus::Request& request);

/// The registers that a 16 or 23 writes, as the drive wants them: values, and the position of an
/// opcode whose order is stated, exchanged where the client's order `seen` is another one.
std::vector<std::uint8_t> data_in_order(const drive::Device& device,
                                        std::optional<drive::WordOrder> seen,
                                        const modbus::Request& request);

}  // namespace mbgate::routing
