// SPDX-License-Identifier: Apache-2.0
// How long a request is, judged by its first bytes: what another client on the line asks must be
// told from what devices answer.
#pragma once

#include "modbus/response.hpp"

namespace mbgate::modbus {

/// The length of the request PDU that begins with `prefix` (function code first, not empty).
/// Source: Application Protocol V1.1b3, section 6. Opaque where the function does not say it.
PduLength request_length(Bytes prefix);

}  // namespace mbgate::modbus
