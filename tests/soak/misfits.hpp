// SPDX-License-Identifier: Apache-2.0
// Good answers that are not what was asked for.
#pragma once

#include <functional>
#include <vector>

#include "soak/plan.hpp"

namespace mbgate::soak {

/// Does a fault happen that comes as often, in a thousand, and has this name?
using Happens = std::function<bool(unsigned, const char*)>;

/// Makes of an answer to a write one with another address, value or quantity; takes from one to a
/// read the last register or the last eight bits. False: it is left as it is.
bool make_misfit(std::vector<std::uint8_t>& pdu, const FaultRates& rates, Random& random,
                 const Happens& happens);

}  // namespace mbgate::soak
