// SPDX-License-Identifier: Apache-2.0
#include "gateway/settings_diff.hpp"

#include <algorithm>

namespace mbgate::gateway {
namespace {

template <typename Named>
std::vector<std::optional<std::size_t>> places_of(const std::vector<Named>& old,
                                                  const std::vector<Named>& next) {
  std::vector<std::optional<std::size_t>> places;
  for (const Named& it : old) {
    const auto found = std::ranges::find(next, it.name, &Named::name);
    places.push_back(found == next.end()
                         ? std::nullopt
                         : std::optional(static_cast<std::size_t>(found - next.begin())));
  }
  return places;
}

template <typename Id>
std::optional<Id> number(const std::optional<std::size_t>& place) {
  return place ? std::optional(Id{static_cast<std::uint32_t>(*place)}) : std::nullopt;
}

}  // namespace

SettingsDiff::SettingsDiff(const Settings& old, const Settings& next)
    : listeners_(places_of(old.listeners, next.listeners)),
      buses_(places_of(old.buses, next.buses)),
      devices_(places_of(old.devices, next.devices)) {
  for (std::size_t place = 0; place < old.buses.size(); ++place) {
    kept_lines_.push_back(buses_[place] &&
                          next.buses[*buses_[place]].line == old.buses[place].line);
  }
}

std::optional<ListenerId> SettingsDiff::listener(ListenerId old) const {
  return number<ListenerId>(listeners_[static_cast<std::size_t>(old)]);
}

std::optional<BusId> SettingsDiff::bus(BusId old) const {
  return number<BusId>(buses_[static_cast<std::size_t>(old)]);
}

}  // namespace mbgate::gateway
