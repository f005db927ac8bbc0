// SPDX-License-Identifier: Apache-2.0
// Where the parts of the gateway put what the shell is to do for clients, and what is to be told.
#pragma once

#include "bus/action_queue.hpp"
#include "gateway/action.hpp"

namespace mbgate::gateway {

using ActionQueue = bus::ActionQueue<Action>;

}  // namespace mbgate::gateway
