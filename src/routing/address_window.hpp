// SPDX-License-Identifier: Apache-2.0
// Rewriting of table addresses: what a client sees at `from` lies in the device at `to`, possibly
// in another table.
#pragma once

#include <span>

#include "modbus/request.hpp"
#include "routing/route.hpp"

namespace mbgate::routing {

/// The request as the device must see it. Each range that it names must lie wholly in one window
/// (else 02); what the other table cannot do, such as writing input registers, is 01. Requests that
/// name no table pass unchanged; the functions of the route decide whether they may.
Result<modbus::Request, modbus::ExceptionCode> through_windows(
    std::span<const AddressWindow> windows, const modbus::Request& request);

}  // namespace mbgate::routing
