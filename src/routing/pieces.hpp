// SPDX-License-Identifier: Apache-2.0
// Splits a range of registers into requests that a drive accepts: none over its limit, none that
// cuts a value, none across the border of a parameter group.
#pragma once

#include <boost/container/small_vector.hpp>

#include "drive/profile.hpp"

namespace mbgate::routing {

using Pieces = boost::container::small_vector<modbus::TableRange, 4>;

/// The pieces of `range`, in order. `limit` must not be smaller than a value of the profile.
Pieces cut(const modbus::TableRange& range, std::uint16_t limit, const drive::Profile& profile);

}  // namespace mbgate::routing
