// SPDX-License-Identifier: Apache-2.0
#include "gateway/settings/numbering.hpp"

#include <utility>

namespace mbgate::gateway {
namespace {

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
Named gone(const Named& known) {
  Named gone;
  gone.name = known.name;
  if constexpr (requires { gone.is_gone = true; }) {
    gone.is_gone = true;
  } else {
    gone.bus = drive::kNoBus;
  }
  return gone;
}

template <typename Named>
std::vector<Named> at_numbers(const std::vector<Named>& known, std::vector<Named> read,
                              const Numbers& numbers) {
  std::vector<Named> placed;
  placed.reserve(known.size() + read.size());
  for (const Named& it : known) {
    placed.push_back(gone(it));
  }
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

std::vector<DeviceGuard> guards_at(std::vector<DeviceGuard> read, const Numbers& devices) {
  std::vector<DeviceGuard> guards;
  for (std::size_t place = 0; place < read.size(); ++place) {
    guards.resize(std::max(guards.size(), devices[place] + 1));
    guards[devices[place]] = std::move(read[place]);
  }
  return guards;
}

}  // namespace

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
  read.listeners = at_numbers(in_force.listeners, std::move(read.listeners), listeners);
  read.buses = at_numbers(in_force.buses, std::move(read.buses), buses);
  read.devices = at_numbers(in_force.devices, std::move(read.devices), devices);
  read.guards = guards_at(std::move(read.guards), devices);
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
