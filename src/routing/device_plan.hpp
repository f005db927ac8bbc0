// SPDX-License-Identifier: Apache-2.0
// Turns one request to configured devices into the requests that their drives accept: values whole
// and in the drive's word order, nothing over its limits or across its parameter groups, only with
// functions that it has; a broadcast in each form that the devices use.
#pragma once

#include <boost/container/small_vector.hpp>
#include <optional>

#include "drive/device.hpp"
#include "drive/profile.hpp"
#include "modbus/request.hpp"
#include "routing/plan.hpp"
#include "routing/route.hpp"

namespace mbgate::routing {

// Splits a range of registers into requests that a drive accepts: none over its limit, none that
// cuts a value, none across the border of a parameter group.

using Pieces = boost::container::small_vector<modbus::TableRange, 4>;

/// The pieces of `range`, in order. `limit` must not be smaller than a value of the profile.
Pieces cut(const modbus::TableRange& range, std::uint16_t limit, const drive::Profile& profile);

using Requests = boost::container::small_vector<modbus::Request, 1>;

struct DevicePlan {
  Requests requests;
  Reply reply;
};

/// `seen`: the word order that the client wants to see; none: nothing is exchanged. Errors: 01 for
/// a communication register, 03 for what cuts a value or is over a limit and may not be split.
Result<DevicePlan, modbus::ExceptionCode> plan_for(const drive::Device& device,
                                                   std::optional<drive::WordOrder> seen,
                                                   const modbus::Request& request);

// A broadcast write, in every form that the devices on the buses use: address 0 for the standard
// ones, and the forms that profiles state.

using BroadcastFrames = boost::container::small_vector<drive::Transaction, 2>;

/// Errors: 01 where a device would be reconfigured; 02 where no device takes such a broadcast; 03
/// over a device's limit, or for a value that not all receivers have at the same place and in the
/// same word order. Unless the route says `broadcast_mixed`, also 02 where a device of the bus has
/// no such register, and 03 where it means another thing to one that hears it. What stops a device
/// is refused only by 01, and where no form can carry it.
Result<BroadcastFrames, modbus::ExceptionCode> plan_broadcast(const ResolvedRoute& resolved,
                                                              const modbus::Request& request);

/// The devices of its buses that the broadcast is not for: their form cannot carry it, or they have
/// no such register, or, of a stop, it does not stop them.
[[nodiscard]] std::vector<const drive::Device*> not_addressed(const ResolvedRoute& resolved,
                                                              const Plan& plan, bool is_stop);

}  // namespace mbgate::routing
