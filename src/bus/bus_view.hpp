// SPDX-License-Identifier: Apache-2.0
// A read-only view of a bus as a whole: the waiting requests and how long they have waited, the
// transmissions on the wire, the state of the line. It must not outlive the bus.
#pragma once

#include <algorithm>
#include <bitset>

#include "bus/parts.hpp"

namespace mbgate::bus {

class BusView {
 public:
  explicit BusView(const Parts& parts) : parts_(parts) {}

  [[nodiscard]] LineState line_state(Instant now) const { return parts_.line.state(now); }
  /// How long nothing at all was received on the open line.
  [[nodiscard]] Duration silence(Instant now) const { return parts_.adapter.silence(now); }
  /// Transmissions on the wire.
  [[nodiscard]] std::size_t in_flight() const { return parts_.transmissions.in_flight(); }
  /// Requests that wait, stops among them.
  [[nodiscard]] std::size_t waiting() const { return parts_.queue.size() + parts_.stops.size(); }
  /// The client address of which the most requests wait for the line, and not for their device.
  [[nodiscard]] std::optional<BusQueue::Most> most_waiting(Instant now) const {
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
  /// How long the request has waited that waits longest, stops apart.
  [[nodiscard]] Duration longest_waiting(Instant now) const {
    const auto oldest = parts_.queue.oldest();
    return oldest ? std::max(now - *oldest, Duration{0}) : Duration{0};
  }
  /// How long the device at the address is still left alone because it owes an answer.
  [[nodiscard]] Duration held_back(std::uint8_t address, Instant now) const {
    const DeviceEntry& entry = parts_.devices[address];
    const Instant until = entry.hold.until(entry.in_force());
    return parts_.quarantines() && until > now ? until - now : Duration{0};
  }
  /// A device behind a line that is not open is not answering.
  [[nodiscard]] DeviceState state_of(std::uint8_t address) const {
    const DeviceState state = parts_.devices[address].health.state();
    return state == DeviceState::answering && !parts_.link.serves() ? DeviceState::line_not_open
                                                                    : state;
  }

 private:
  const Parts& parts_;
};

}  // namespace mbgate::bus
