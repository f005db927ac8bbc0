// SPDX-License-Identifier: Apache-2.0
#include "soak/meanings.hpp"

#include <algorithm>

namespace mbgate::soak {

void Meanings::add_device(Meaning& meaning, std::size_t index) const {
  const drive::Device& device = plan_.settings.devices[index];
  const drive::Limits& limits = device.profile.limits;
  meaning.insert(meaning.end(),
                 {index, device.address,
                  device.word_order ? 1U + static_cast<std::size_t>(*device.word_order) : 0U,
                  limits.read.back(), limits.write_registers});
}

// For all: whoever is on these buses.
Meanings::Meaning Meanings::of(const Door& door) const {
  Meaning meaning = door.buses;
  const auto order = door.route ? plan_.settings.routes[*door.route].word_order : std::nullopt;
  meaning.push_back(order ? 1U + static_cast<std::size_t>(*order) : 0U);
  meaning.push_back(door.moves);
  if (door.device) {
    add_device(meaning, *door.device);
    return meaning;
  }
  for (std::size_t index = 0; index < plan_.settings.devices.size(); ++index) {
    const auto bus = static_cast<std::size_t>(plan_.settings.devices[index].bus);
    const bool is_there = std::ranges::find(door.buses, bus) != door.buses.end();
    if (is_there && !plan_.absent.devices[index]) {
      add_device(meaning, index);
    }
  }
  return meaning;
}

std::map<Meanings::Unit, Meanings::Meaning> Meanings::in_force() const {
  std::map<Unit, Meaning> all;
  for (const Door& door : plan_.doors) {
    // The address of the AiC may be a device like others.
    if (!door.absent && !door.only_autonics && !plan_.absent.listeners[door.listener]) {
      all[{door.listener, door.unit}] = of(door);
    }
  }
  return all;
}

// Whether the units of a listener that comes back mean what they did is not followed here. Nothing
// that came before can be there: its connections went with it.
void Meanings::after_reload(Instant now) {
  const auto before = std::exchange(now_, in_force());
  const auto were_away = std::exchange(are_away_, plan_.absent.listeners);
  const auto note = [&](const auto& old, const auto& others) {
    for (const auto& [unit, meaning] : old) {
      const auto other = others.find(unit);
      if (other == others.end() || other->second != meaning) {
        Change& change = changes_[unit];
        change.at = now;
        const bool is_away = were_away[unit.first] || are_away_[unit.first];
        change.surely = is_away ? change.surely : now;
      }
    }
  };
  note(before, now_);
  note(now_, before);
}

Meanings::Change Meanings::change_of(std::size_t listener, std::uint8_t unit) const {
  const auto change = changes_.find({listener, unit});
  return change == changes_.end() ? Change{} : change->second;
}

}  // namespace mbgate::soak
