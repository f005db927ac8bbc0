// SPDX-License-Identifier: Apache-2.0
#include "bus/bus_view.hpp"

#include <algorithm>
#include <bitset>

namespace mbgate::bus {

std::optional<BusQueue::Most> BusView::most_waiting(Instant now) const {
  if (parts_.queue.size() == 0) {
    return std::nullopt;
  }
  std::bitset<kAddresses> held;
  for (std::size_t address = 0; address < kAddresses; ++address) {
    const auto number = static_cast<std::uint8_t>(address);
    const DeviceEntry& entry = parts_.devices[number];
    held[address] =
        entry.health.is_offline() || entry.free_at > now || held_back(number, now) > Duration{0};
  }
  return parts_.queue.most_waiting(held);
}

Duration BusView::longest_waiting(Instant now) const {
  const auto oldest = parts_.queue.oldest();
  return oldest ? std::max(now - *oldest, Duration{0}) : Duration{0};
}

Duration BusView::held_back(std::uint8_t address, Instant now) const {
  const DeviceEntry& entry = parts_.devices[address];
  const Instant until = entry.hold.until(entry.in_force());
  return parts_.quarantines() && until > now ? until - now : Duration{0};
}

}  // namespace mbgate::bus
