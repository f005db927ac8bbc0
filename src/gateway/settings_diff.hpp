// SPDX-License-Identifier: Apache-2.0
// What becomes of listeners, buses and devices when settings change: the same name is the same
// thing, at whatever place.
#pragma once

#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "gateway/settings.hpp"

namespace mbgate::gateway {

/// In place of a bus that is no more.
inline constexpr BusId kNoBus{std::numeric_limits<std::uint32_t>::max()};

class SettingsDiff {
 public:
  SettingsDiff(const Settings& old, const Settings& next);

  /// The new number; nothing if there is none.
  [[nodiscard]] std::optional<ListenerId> listener(ListenerId old) const;
  [[nodiscard]] std::optional<BusId> bus(BusId old) const;
  [[nodiscard]] std::optional<std::size_t> device(std::size_t old) const { return devices_[old]; }
  /// What is known of each device, by its place, goes over to its new place.
  template <typename Known>
  void move_devices(std::vector<Known>& known, std::size_t devices) const {
    std::vector<Known> moved(devices);
    for (std::size_t old = 0; old < known.size(); ++old) {
      if (const auto place = device(old)) {
        moved[*place] = std::move(known[old]);
      }
    }
    known = std::move(moved);
  }
  /// Does the bus go on over the same line?
  [[nodiscard]] bool keeps_line(BusId old) const {
    return kept_lines_[static_cast<std::size_t>(old)];
  }

 private:
  using Places = std::vector<std::optional<std::size_t>>;
  Places listeners_;
  Places buses_;
  Places devices_;
  std::vector<bool> kept_lines_;
};

}  // namespace mbgate::gateway
