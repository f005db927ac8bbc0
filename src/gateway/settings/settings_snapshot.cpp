// SPDX-License-Identifier: Apache-2.0
#include "gateway/settings/settings_snapshot.hpp"

#include <algorithm>
#include <utility>

namespace mbgate::gateway {
namespace {

std::vector<routing::ListenerKind> kinds_of(const Settings& settings) {
  std::vector<routing::ListenerKind> kinds;
  kinds.reserve(settings.listeners.size());
  for (const auto& listener : settings.listeners) {
    const bool is_ascii =
        listener.bus && settings.bus(*listener.bus).line.framing == bus::Framing::ascii;
    kinds.push_back({listener.bus, listener.broadcast, listener.broadcast_reply,
                     listener.broadcast_mixed, !is_ascii});
  }
  return kinds;
}

const drive::Device* device_at(const SettingsSnapshot& snapshot, BusId bus, std::uint8_t address) {
  const auto place = snapshot.devices.at(bus, address);
  return place ? &snapshot.settings.devices[*place] : nullptr;
}

using Numbers = std::vector<std::size_t>;

// Of each that was read; their names differ.
template <typename Named>
Numbers numbers_of(const std::vector<Named>& known, const std::vector<Named>& read) {
  Numbers numbers;
  numbers.reserve(read.size());
  std::size_t unused = known.size();
  for (const Named& it : read) {
    const auto same = std::ranges::find(known, it.name, &Named::name);
    numbers.push_back(same == known.end() ? unused++
                                          : static_cast<std::size_t>(same - known.begin()));
  }
  return numbers;
}

template <typename Named>
std::vector<Named> all_gone(const std::vector<Named>& known) {
  std::vector<Named> all;
  for (const Named& it : known) {
    Named& gone = all.emplace_back();
    gone.name = it.name;
    if constexpr (requires { gone.is_gone = true; }) {
      gone.is_gone = true;
    } else {
      gone.bus = drive::kNoBus;
    }
  }
  return all;
}

template <typename Entry>
std::vector<Entry> at_numbers(std::vector<Entry> placed, std::vector<Entry> read,
                              const Numbers& numbers) {
  for (std::size_t place = 0; place < read.size(); ++place) {
    placed.resize(std::max(placed.size(), numbers[place] + 1));
    placed[numbers[place]] = std::move(read[place]);
  }
  return placed;
}

template <typename Id>
Id number_of(const Numbers& numbers, Id written) {
  return Id{static_cast<std::uint32_t>(numbers[static_cast<std::size_t>(written)])};
}

}  // namespace

SettingsSnapshot::SettingsSnapshot(Settings given)
    : settings(std::move(given)),
      routes(kinds_of(settings), settings.routes, settings.devices),
      devices(settings.devices, settings.buses.size()) {}

const DeviceGuard& SettingsSnapshot::guard(std::size_t device) const {
  static const DeviceGuard kNoRules;
  return device < settings.guards.size() ? settings.guards[device] : kNoRules;
}

std::optional<std::size_t> place_of_same_drive(const Settings& old, std::size_t place,
                                               const Settings& next) {
  const drive::Device& before = old.devices[place];
  const auto is_same = [&](const drive::Device& it) {
    return !before.is_gone() && !it.is_gone() && before.address == it.address &&
           old.bus(before.bus).line.has_end_of(next.bus(it.bus).line);
  };
  if (place < next.devices.size() && is_same(next.devices[place])) {
    return place;  // as most are
  }
  const auto same = std::ranges::find_if(next.devices, is_same);
  return same == next.devices.end()
             ? std::nullopt
             : std::optional(static_cast<std::size_t>(same - next.devices.begin()));
}

bool is_other_device(const SettingsSnapshot& old, const SettingsSnapshot& next, BusId bus,
                     std::uint8_t address) {
  const drive::Device* before = device_at(old, bus, address);
  const drive::Device* after = device_at(next, bus, address);
  if (before == nullptr || after == nullptr) {
    return before != after;
  }
  return !after->understands_as(*before);
}

bool has_other_devices(const SettingsSnapshot& old, const SettingsSnapshot& next, BusId bus) {
  for (std::size_t address = 0; address < DeviceIndex::kAddresses; ++address) {
    if (is_other_device(old, next, bus, static_cast<std::uint8_t>(address))) {
      return true;
    }
  }
  return false;
}

bool unit_means_otherwise(const UnitOfListener& place, const SettingsSnapshot& old,
                          const SettingsSnapshot& next, std::optional<BusId> on_bus) {
  const auto& [listener, unit] = place;
  const bool was_own = old.settings.status_unit == unit;
  const bool is_own = next.settings.status_unit == unit;
  if (was_own || is_own) {
    return was_own != is_own;
  }
  const routing::ResolvedRoute* before = old.routes.find(listener, unit);
  const routing::ResolvedRoute* after = next.routes.find(listener, unit);
  if (before == nullptr || after == nullptr) {
    return before != after;
  }
  const routing::Route& from = before->route;
  const routing::Route& to = after->route;
  const bool is_broadcast = after->is_broadcast();
  if (before->is_broadcast() != is_broadcast || from.word_order != to.word_order ||
      from.windows != to.windows ||
      (!is_broadcast && from.address_of(unit) != to.address_of(unit))) {
    return true;
  }
  const auto differs_on = [&](BusId bus) {
    return std::ranges::find(to.buses, bus) == to.buses.end() ||
           !old.settings.bus(bus).line.has_end_of(next.settings.bus(bus).line) ||
           (is_broadcast ? has_other_devices(old, next, bus)
                         : is_other_device(old, next, bus, to.address_of(unit)));
  };
  return on_bus ? differs_on(*on_bus)
                : from.buses != to.buses || std::ranges::any_of(to.buses, differs_on);
}

DeviceIndex::DeviceIndex(std::span<const drive::Device> devices, std::size_t buses)
    : devices_(devices), buses_(buses) {
  for (std::size_t place = 0; place < devices.size(); ++place) {
    const drive::Device& device = devices[place];
    for (std::size_t address = 0; address < kAddresses; ++address) {
      if (!device.is_gone() && device.stands_for(static_cast<std::uint8_t>(address))) {
        buses_[static_cast<std::size_t>(device.bus)].at(address) = place;
      }
    }
  }
}

std::optional<std::size_t> DeviceIndex::at(drive::BusId bus, std::uint8_t address) const {
  return buses_[static_cast<std::size_t>(bus)].at(address);
}

DevicePlaces DeviceIndex::reached_by(const drive::Transaction& transaction) const {
  DevicePlaces reached;
  if (const auto place = at(transaction.bus, transaction.address); !transaction.broadcast) {
    reached.assign(place ? 1 : 0, place.value_or(0));
    return reached;
  }
  for (std::size_t place = 0; place < devices_.size(); ++place) {
    if (devices_[place].bus == transaction.bus) {
      reached.push_back(place);
    }
  }
  return reached;
}

DevicePlaces DeviceIndex::addressed_by(const drive::Transaction& transaction) const {
  DevicePlaces places = reached_by(transaction);
  const auto deaf = std::ranges::remove_if(places, [&](std::size_t place) {
    return !devices_[place].is_addressed_by(transaction.address, transaction.broadcast);
  });
  places.erase(deaf.begin(), deaf.end());
  return places;
}

Settings numbered_after(const Settings& in_force, Settings read) {
  const Numbers listeners = numbers_of(in_force.listeners, read.listeners);
  const Numbers buses = numbers_of(in_force.buses, read.buses);
  const Numbers devices = numbers_of(in_force.devices, read.devices);
  for (ListenerSettings& listener : read.listeners) {
    if (listener.bus) {
      listener.bus = number_of(buses, *listener.bus);
    }
  }
  for (drive::Device& device : read.devices) {
    device.bus = number_of(buses, device.bus);
  }
  for (routing::Route& route : read.routes) {
    for (BusId& bus : route.buses) {
      bus = number_of(buses, bus);
    }
    if (route.listener) {
      route.listener = number_of(listeners, *route.listener);
    }
    if (route.device) {
      route.device = devices[*route.device];
    }
  }
  for (routing::AccessRule& rule : read.rules) {
    for (ListenerId& listener : rule.listeners) {
      listener = number_of(listeners, listener);
    }
    for (std::size_t& device : rule.devices) {
      device = devices[device];
    }
  }
  read.listeners = at_numbers(all_gone(in_force.listeners), std::move(read.listeners), listeners);
  read.buses = at_numbers(all_gone(in_force.buses), std::move(read.buses), buses);
  read.devices = at_numbers(all_gone(in_force.devices), std::move(read.devices), devices);
  read.guards = at_numbers({}, std::move(read.guards), devices);
  read.written_order = {buses, devices};
  return read;
}

bool keeps_line(const Settings& old, const Settings& next, BusId bus) {
  const bus::BusSettings& now = next.bus(bus);
  const bus::BusSettings& before = old.bus(bus);
  // Without identifiers answers that come in another order could not be told apart.
  return !now.is_gone && now.line == before.line &&
         now.has_identifiers() == before.has_identifiers();
}

}  // namespace mbgate::gateway
