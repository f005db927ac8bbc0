// SPDX-License-Identifier: Apache-2.0
// Where the parts of the gateway put actions for clients and reports for the operator.
#pragma once

#include "bus/action_queue.hpp"
#include "gateway/action.hpp"

namespace mbgate::gateway {

using ActionQueue = bus::ActionQueue<Action>;

}  // namespace mbgate::gateway
