// SPDX-License-Identifier: Apache-2.0
// Who the gateway says that it is: 43/14 of its own unit. Of what else that is asked nothing is
// said.
#pragma once

#include <string>

#include "soak/specification.hpp"

namespace mbgate::soak {

/// What is wrong with the good answer to a request; nothing if it is right. A stream that begins at
/// an object that it does not have restarts at the first one (Modbus specification, 6.21).
std::string objection_to_identity(spec::Bytes request, spec::Bytes answer);
/// 02 only says that there is no such object, which a stream does not need; 03, no such code.
bool may_refuse_identity(spec::Bytes request, std::uint8_t exception);

}  // namespace mbgate::soak
