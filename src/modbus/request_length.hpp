// SPDX-License-Identifier: Apache-2.0
// The length of a request, from its first bytes. It is needed to tell the requests of another
// client on the line from the responses of devices.
#pragma once

#include "modbus/response.hpp"

namespace mbgate::modbus {

/// The length of the request PDU that begins with `prefix` (function code first, not empty).
/// Source: Application Protocol V1.1b3, section 6. Opaque if the function does not determine it.
PduLength request_length(Bytes prefix);

}  // namespace mbgate::modbus
