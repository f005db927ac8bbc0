// SPDX-License-Identifier: Apache-2.0
// Rewriting of table addresses: what a client sees at `from` lies in the device at `to`.
#pragma once

#include <optional>

#include "modbus/request.hpp"
#include "routing/route.hpp"

namespace mbgate::routing {

/// The request as the device must see it; nothing if any part of it lies outside the window.
/// Requests that name no table pass unchanged: whether they may is the business of the route's
/// functions.
std::optional<modbus::Request> through_window(const AddressWindow& window,
                                              const modbus::Request& request);

/// The device's response as the client must see it: the addresses that 05, 06, 15, 16 and 22 repeat
/// are those of the client's own request.
modbus::Pdu back_through_window(const modbus::Request& client_request, const modbus::Pdu& response);

}  // namespace mbgate::routing
