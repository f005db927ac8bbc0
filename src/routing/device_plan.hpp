// SPDX-License-Identifier: Apache-2.0
// Turns one request to a configured device into the requests that its drive accepts: values whole
// and in the drive's word order, nothing over its limits or across its parameter groups, only with
// functions that it has.
#pragma once

#include <boost/container/small_vector.hpp>
#include <optional>

#include "drive/device.hpp"
#include "drive/profile.hpp"
#include "modbus/request.hpp"
#include "routing/reply.hpp"

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

}  // namespace mbgate::routing
