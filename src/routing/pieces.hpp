// SPDX-License-Identifier: Apache-2.0
// Cutting a stretch of registers into requests that a drive takes: none longer than its limit, none
// through a value, none across the border of a parameter group.
#pragma once

#include <boost/container/small_vector.hpp>

#include "drive/profile.hpp"

namespace mbgate::routing {

using Pieces = boost::container::small_vector<modbus::TableRange, 4>;

/// The pieces of `range`, in order. `limit` must not be smaller than a value of the profile.
Pieces cut(const modbus::TableRange& range, std::uint16_t limit, const drive::Profile& profile);

}  // namespace mbgate::routing
