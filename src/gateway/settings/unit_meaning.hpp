// SPDX-License-Identifier: Apache-2.0
// What a request means is said by the settings: to which device its unit leads, and what is
// understood there. Other settings may make something else of the same request.
#pragma once

#include "gateway/settings/settings_snapshot.hpp"

namespace mbgate::gateway {

/// Does a request that was made for the device at the address mean something else there now? A
/// device that appears where none was counts, and one that is gone.
[[nodiscard]] bool is_other_device(const SettingsSnapshot& old, const SettingsSnapshot& next,
                                   BusId bus, std::uint8_t address);

/// The same of any device of the bus.
[[nodiscard]] bool has_other_devices(const SettingsSnapshot& old, const SettingsSnapshot& next,
                                     BusId bus);

/// Does the unit lead to another device or to other registers, is it understood otherwise, or does
/// it no longer lead anywhere? A bus is the same one as long as it keeps its name, whatever its
/// port. The listener is one of `old`.
[[nodiscard]] bool unit_means_otherwise(ListenerId listener, std::uint8_t unit,
                                        const SettingsSnapshot& old, const SettingsSnapshot& next);

}  // namespace mbgate::gateway
