// SPDX-License-Identifier: Apache-2.0
// A broadcast write, in every form that the devices on the buses use: address 0 for the standard
// ones, and the forms that profiles state.
#pragma once

#include <boost/container/small_vector.hpp>

#include "modbus/request.hpp"
#include "routing/resolved_route.hpp"

namespace mbgate::routing {

struct BroadcastFrame {
  BusId bus;
  drive::BroadcastForm form;
  modbus::Request request;
};

using BroadcastFrames = boost::container::small_vector<BroadcastFrame, 2>;

/// Errors: 01 where a device would be reconfigured; 02 where no device takes such a broadcast; 03
/// over a device's limit, or for a value that not all receivers have at the same place and in the
/// same word order. Unless the route says `broadcast_mixed`, also 02 where a device of the bus has
/// no such register, and 03 where it means another thing to one that hears it. What stops a device
/// is refused only by 01, and where no form can carry it.
Result<BroadcastFrames, modbus::ExceptionCode> plan_broadcast(const ResolvedRoute& resolved,
                                                              const modbus::Request& request);

class Plan;

/// The devices of its buses that the broadcast is not for: their form cannot carry it, or they have
/// no such register, or, of a stop, it does not stop them.
[[nodiscard]] std::vector<const drive::Device*> not_addressed(const ResolvedRoute& resolved,
                                                              const Plan& plan, bool is_stop);

}  // namespace mbgate::routing
