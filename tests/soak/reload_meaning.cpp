// SPDX-License-Identifier: Apache-2.0
// Reloads that change what requests mean: what waits for such a device is taken back. And those
// after which something is not there, or is there again.
#include <algorithm>
#include <ranges>
#include <string>

#include "soak/reload.hpp"

namespace mbgate::soak {

namespace {

constexpr std::uint8_t kMovedFrom = 41;  // behind the addresses of the plan
constexpr std::uint8_t kMovedTo = 58;

}  // namespace

bool Reloads::change_route(std::size_t index) {
  routing::Route& route = plan_.settings.routes[index];
  if (!route.device || plan_.absent.routes[index] || !are_within(*route.device)) {
    return false;
  }
  if (random_.chance(500)) {
    if (!are_settled(*route.device)) {
      return false;
    }
    route.access = random_.chance(300) ? routing::Access::read_only : routing::Access::read_write;
    return true;
  }
  route.word_order.reset();
  const bool are_known = std::ranges::all_of(
      plan_.settings.devices, [](const auto& it) { return it.word_order.has_value(); });
  if (random_.chance(600) && are_known) {
    route.word_order = random_.one_of({drive::WordOrder::big, drive::WordOrder::little});
  }
  return true;
}

bool Reloads::change_device(std::size_t index) {
  drive::Device& device = plan_.settings.devices[index];
  const auto bus = static_cast<std::size_t>(device.bus);
  if (plan_.absent.devices[index] || !are_within(index) || !is_sure(bus) ||
      !are_broadcasts_settled(bus)) {
    return false;
  }
  switch (random_.between(0U, 2U)) {
    case 0:
      device.word_order = device.word_order == drive::WordOrder::big ? drive::WordOrder::little
                                                                     : drive::WordOrder::big;
      break;
    case 1: {
      drive::Limits& limits = device.profile.limits;
      const auto before = limits.read.back();
      while (limits.read.back() == before) {
        limits.read[2] = limits.read[3] = random_.between<std::uint16_t>(4, 64);
      }
      limits.write_registers = random_.between<std::uint16_t>(4, 8);
      break;
    }
    default:
      if (!move(device)) {
        return false;
      }
  }
  devices_[index].adopt(device);
  reload_.touched.push_back(bus);
  return true;
}

// To one that no device has. No answer may be owed from either: the line leaves one alone for less.
bool Reloads::move(drive::Device& device) {
  const auto address = random_.between<std::uint8_t>(kMovedFrom, kMovedTo);
  const bool taken = std::ranges::any_of(plan_.settings.devices, [&](const drive::Device& other) {
    return other.bus == device.bus && other.address == address;
  });
  const auto bus = static_cast<std::size_t>(device.bus);
  if (taken || oracle_.is_quarantined(bus, address) ||
      oracle_.is_quarantined(bus, device.address)) {
    return false;
  }
  device.address = address;
  return true;
}

bool Reloads::change_line(std::size_t index) {
  if (plan_.absent.buses[index]) {
    return false;
  }
  if (bus::LineSettings& line = plan_.settings.buses[index].line; line.remote) {
    ++line.remote->port;
  } else if (lines_.chance(500)) {
    line.low_latency = !line.low_latency;  // the same port: what its drives owe still comes
  } else {
    const auto before = line;
    const bool echoes = plan_.echoes[index];
    const bus::LineKind kind = plan_.kinds[index];
    line.baud = modbus::Baud{
        random_.one_of<std::uint32_t>({9600, 19200, 38400, 57600, 115200, 230400, 921600})};
    line.framing = random_.one_of({bus::Framing::rtu, bus::Framing::rtu, bus::Framing::ascii});
    line.echo = random_.chance(200);
    draw_line_kind(plan_, index, lines_);
    if (line == before) {
      plan_.echoes[index] = echoes;
      plan_.kinds[index] = kind;
      return false;
    }
  }
  reload_.touched.push_back(index);
  reload_.lines.push_back(index);
  return true;
}

// Requests through its units, which lead elsewhere without it. Whether a rule denies a broadcast
// depends on which units lead to its lines.
bool Reloads::is_route_settled(std::size_t index) const {
  const routing::Route& route = plan_.settings.routes[index];
  const bool asks_units = std::ranges::any_of(plan_.rules, [](const SpokenRule& rule) {
    return !rule.permits && rule.writes && !rule.units.empty();
  });
  return std::ranges::all_of(plan_.doors, [&](const Door& door) {
    const bool has_its_unit = route.first_unit <= door.unit && door.unit <= route.last_unit;
    const bool is_meant = door.route == index || (route.listener && has_its_unit);
    return (!is_meant || oracle_.is_within(door)) &&
           (!asks_units || door.device || oracle_.is_settled(door));
  });
}

bool Reloads::switch_route(std::size_t index) {
  const bool settled = is_route_settled(index);
  if (plan_.settings.routes[index].first_unit == kAutonicsAddress) {
    return false;  // its door follows the route to all
  }
  if (settled) {
    plan_.absent.routes[index].flip();
  }
  return settled;
}

// Its unit leads to another device from then on.
bool Reloads::turn_route(std::size_t index) {
  routing::Route& route = plan_.settings.routes[index];
  const auto other = std::ranges::find_if(plan_.doors, [&](const Door& door) {
    return door.route == index && door.device && door.device != route.device &&
           !plan_.absent.devices[*door.device];
  });
  const bool settled = is_route_settled(index);
  if (!route.device || other == plan_.doors.end() || !settled || plan_.absent.routes[index]) {
    return false;
  }
  route.device = other->device;
  route.buses = {plan_.settings.devices[*other->device].bus};
  return true;
}

// Which forms a broadcast goes out in, and whether it may, depends on who is there.
bool Reloads::are_broadcasts_settled(std::size_t bus) const {
  return std::ranges::all_of(plan_.doors, [&](const Door& door) {
    return door.device || std::ranges::find(door.buses, bus) == door.buses.end() ||
           oracle_.is_settled(door);
  });
}

// With its bus gone it is gone too, and comes back with it.
bool Reloads::switch_device(std::size_t index) {
  const drive::Device& device = plan_.settings.devices[index];
  const auto bus = static_cast<std::size_t>(device.bus);
  if (plan_.absent.buses[bus] || !are_within(index) || !is_sure(bus) ||
      !are_broadcasts_settled(bus) || oracle_.is_quarantined(bus, device.address)) {
    return false;
  }
  // Where nobody hears a broadcast it stops nobody, and is a write like others.
  const auto is_there = [&](std::size_t other) {
    return other != index && !plan_.absent.devices[other] &&
           plan_.settings.devices[other].bus == device.bus;
  };
  const auto all = std::views::iota(std::size_t{0}, plan_.settings.devices.size());
  if (!std::ranges::any_of(all, is_there)) {
    return false;
  }
  plan_.absent.devices[index].flip();
  reload_.touched.push_back(bus);
  return true;
}

// One to which nothing is written when nobody is left; before another one goes it comes back.
bool Reloads::switch_unwatched(std::size_t index) {
  const auto& absent = plan_.absent.devices;
  const auto gone = std::ranges::find(absent, true);
  const auto place = gone == absent.end() ? index : static_cast<std::size_t>(gone - absent.begin());
  return plan_.settings.guards[place].failsafe.empty() && switch_device(place);
}

bool Reloads::switch_bus(std::size_t index) {
  const auto is_on_it = [&](std::size_t bus) { return bus == index; };
  for (std::size_t place = 0; place < plan_.doors.size(); ++place) {
    const Door& door = plan_.doors[place];
    const bool leads_there =
        std::ranges::any_of(buses_of_[place], is_on_it) ||
        (door.route &&
         is_on_it(static_cast<std::size_t>(plan_.settings.routes[*door.route].buses.front())));
    const bool is_unsettled = std::ranges::any_of(plan_.doors, [&](const Door& other) {
      return other.listener == door.listener && other.unit == door.unit &&
             !oracle_.is_settled(other);
    });
    if (leads_there && is_unsettled) {
      return false;
    }
  }
  if (std::ranges::find(reload_.lines, index) != reload_.lines.end()) {
    return false;
  }
  plan_.absent.buses[index].flip();
  const bool absent = plan_.absent.buses[index];
  for (std::size_t device = 0; device < plan_.settings.devices.size(); ++device) {
    if (is_on_it(static_cast<std::size_t>(plan_.settings.devices[device].bus))) {
      plan_.absent.devices[device] = absent;
    }
  }
  for (std::size_t listener = 0; listener < plan_.settings.listeners.size(); ++listener) {
    const auto& bus = plan_.settings.listeners[listener].bus;
    if (bus && is_on_it(static_cast<std::size_t>(*bus))) {
      plan_.absent.listeners[listener] = absent;
    }
  }
  reload_.touched.push_back(index);
  if (absent) {
    reload_.lines.push_back(index);
  }
  return true;
}

bool Reloads::switch_listener(std::size_t index) {
  const auto& bus = plan_.settings.listeners[index].bus;
  if (bus && plan_.absent.buses[static_cast<std::size_t>(*bus)]) {
    return false;
  }
  plan_.absent.listeners[index].flip();
  return true;
}

bool Reloads::switch_allowed(std::size_t index) {
  std::vector<unsigned>& allowed = plan_.allowed[index];
  const bool were_any = !allowed.empty();
  allowed.clear();
  for (unsigned host = 0; !were_any && host < kMostHosts; ++host) {
    if (random_.chance(600)) {
      allowed.push_back(host);
    }
  }
  plan_.settings.listeners[index].allow = networks_of(allowed);
  return true;
}

// Who may only read there.
bool Reloads::change_rights(std::size_t index) {
  const bool are_settled = std::ranges::all_of(plan_.doors, [&](const Door& door) {
    return door.listener != index || oracle_.is_settled(door);
  });
  if (!are_settled) {
    return false;
  }
  std::vector<unsigned>& readers = plan_.readers[index];
  readers.clear();
  for (unsigned host = 0; host < kMostHosts; ++host) {
    if (random_.chance(150)) {
      readers.push_back(host);
    }
  }
  plan_.settings.listeners[index].read_only = networks_of(readers);
  return true;
}

void Reloads::bring_back() {
  for (std::size_t bus = 0; bus < plan_.absent.buses.size(); ++bus) {
    if (plan_.absent.buses[bus] && switch_bus(bus)) {
      reload_.kinds.push_back("reload_bus_back");
    }
  }
  for (std::size_t device = 0; device < plan_.absent.devices.size(); ++device) {
    if (plan_.absent.devices[device] && switch_device(device)) {
      reload_.kinds.push_back("reload_device_back");
    }
  }
  for (std::size_t route = 0; route < plan_.absent.routes.size(); ++route) {
    if (plan_.absent.routes[route] && switch_route(route)) {
      reload_.kinds.push_back("reload_route_back");
    }
  }
  for (std::size_t listener = 0; listener < plan_.absent.listeners.size(); ++listener) {
    plan_.allowed[listener].clear();
    plan_.settings.listeners[listener].allow.clear();
    if (plan_.absent.listeners[listener] && switch_listener(listener)) {
      reload_.kinds.push_back("reload_listener_back");
    }
  }
}

}  // namespace mbgate::soak
