// SPDX-License-Identifier: Apache-2.0
// Listeners, buses and devices are numbered once, by name: a number that was given keeps its
// meaning, so that nothing that was noted under it can mean another thing after a reload.
#pragma once

#include "gateway/settings.hpp"

namespace mbgate::gateway {

/// Settings that were read anew, at the numbers of those in force: the same name has the same
/// number, what is new gets one that nobody had, and what is gone leaves its own empty (`is_gone`).
[[nodiscard]] Settings numbered_after(const Settings& in_force, Settings read);

/// Does the bus go on over the same line?
[[nodiscard]] bool keeps_line(const Settings& old, const Settings& next, BusId bus);

/// Is the device there before and after?
[[nodiscard]] bool keeps_device(const Settings& old, const Settings& next, std::size_t device);

}  // namespace mbgate::gateway
