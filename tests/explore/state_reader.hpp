// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "explore/state_hash.hpp"

namespace mbgate::gateway {

class Gateway;

}  // namespace mbgate::gateway

namespace mbgate::explore {

/// Adds everything that the machine remembers and that may decide what it does later.
void read_state(gateway::Gateway& gateway, StateHash& hash);

}  // namespace mbgate::explore
