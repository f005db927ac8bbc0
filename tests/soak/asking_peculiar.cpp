// SPDX-License-Identifier: Apache-2.0
// What is for all, and what only some of those who hear it take for a stop or a value.
#include <algorithm>
#include <array>
#include <utility>

#include "soak/asking.hpp"
#include "soak/pdus.hpp"
#include "soak/specification.hpp"

namespace mbgate::soak {

using drive::Device;

const Peculiarity& Asking::peculiarity(const Device& device) const {
  return plan_.peculiar[static_cast<std::size_t>(&device - plan_.settings.devices.data())];
}

// What stops on one line only is left out: elsewhere it would be a write like others.
void Asking::pick_peculiar(Asked& asked) {
  constexpr unsigned kMany = 500;
  const bool are_some = std::ranges::any_of(
      plan_.peculiar, [](const Peculiarity& it) { return it.stops || it.value; });
  if (!are_some || !peculiar_.chance(kMany)) {
    return;
  }
  const Door& door = *asked.door;
  const auto pdu = std::move(asked.pdu);
  const auto value = static_cast<std::uint16_t>(kStopOfSome | (broadcasts_ & 0xFFFU));
  asked.pdu = peculiar_.chance(500) ? fields(6, kBroadcastRegister, value)
                                    : multiple_pdu(kBroadcastRegister, {value});
  const auto stops_on = [&](std::size_t bus) {
    return std::ranges::any_of(std::array{false, true}, [&](bool autonics) {
      return (autonics || !door.only_autonics) &&
             std::ranges::any_of(listeners(bus, autonics),
                                 [&](const Device* device) { return peculiarity(*device).stops; });
    });
  };
  const auto stopped = std::ranges::count_if(door.buses, stops_on);
  const bool is_value = peculiar_.chance(500) && !(door.names_order && verifies(door));
  if (is_value) {
    asked.pdu = multiple_pdu(kValueOfSome, {broadcasts_, 0x5A5A});
  } else if (stopped > 0 && stopped < std::ssize(door.buses)) {
    asked.pdu = pdu;
    return;
  }
  asked.is_shared = false;
  asked.stops_all = asked.for_some = !is_value && stopped > 0;
}

// The value must be there and in the same order for all who hear it, or for none.
void Asking::exchange_peculiar(Asked& asked, const Receivers& receivers) const {
  const auto range = spec::fields_of(asked.pdu)->writes;
  if (asked.refused || receivers.empty() || !range || range->first != kValueOfSome) {
    return;
  }
  const auto has_value = [&](const Device* it) { return peculiarity(*it).value; };
  if (std::ranges::none_of(receivers, has_value)) {
    return;
  }
  const drive::WordOrder* seen = order_seen(*asked.door);
  if (!speak_alike(receivers) || !std::ranges::all_of(receivers, has_value)) {
    asked.refused = 3;
  } else if (seen != nullptr && *seen != *receivers.front()->word_order) {
    asked.pdu = multiple_pdu(kValueOfSome, {0x5A5A, broadcasts_});
  }
}

}  // namespace mbgate::soak
