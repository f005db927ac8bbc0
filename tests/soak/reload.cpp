// SPDX-License-Identifier: Apache-2.0
#include "soak/reload.hpp"

#include <algorithm>

namespace mbgate::soak {

using namespace std::chrono_literals;

namespace {

constexpr int kUnitOfNobody = 250;
constexpr std::uint64_t kLinesChance = 0x4C494E4553ULL;
constexpr std::uint64_t kGuardsChance = 0x475541524453ULL;
constexpr std::uint64_t kPatienceChance = 0x50415449ULL;
constexpr std::uint64_t kHostLimitsChance = 0x484F535453ULL;
constexpr std::uint64_t kWindowsChance = 0x57494E444F57ULL;
constexpr std::uint64_t kOwnChance = 0x52454C4F4144ULL;  // apart from the plant's

}  // namespace

Reloads::Reloads(SoakPlan& plan, Oracle::Devices& devices, const Oracle& oracle, std::uint64_t seed)
    : plan_(plan),
      devices_(devices),
      oracle_(oracle),
      random_(seed ^ kOwnChance),
      lines_(seed ^ kLinesChance),
      guards_(seed ^ kGuardsChance),
      patience_(seed ^ kPatienceChance),
      host_limits_(seed ^ kHostLimitsChance),
      windows_(seed ^ kWindowsChance),
      arrangement_(plan) {
  is_guarded_ = std::ranges::any_of(plan.settings.guards, [](const gateway::DeviceGuard& guard) {
    return guard.writer != gateway::WriterRule::any || !guard.failsafe.empty();
  });
  if (random_.chance(is_guarded_ ? 500 : 700)) {
    every_ = random_.one_of<Duration>({50ms, 200ms, 1s, 5s});
  }
  if (plan.theme != Theme::none) {
    every_ = plan.theme == Theme::busy_line ? 5s : 0ms;
  }
  if (plan.moves_windows) {
    every_ = windows_.one_of<Duration>({50ms, 200ms, 500ms});
  }
  for (const Door& door : plan_.doors) {
    buses_of_.push_back(door.buses);
  }
  meanings_ = meanings();
}

std::optional<Duration> Reloads::pause() {
  return are_any() ? std::optional(random_.duration(every_ / 4, 2 * every_)) : std::nullopt;
}

template <typename Change>
void Reloads::perhaps(unsigned permille, const char* kind, std::size_t count, Change change) {
  if (count > 0 && random_.chance(permille) && (this->*change)(random_.below(count))) {
    reload_.kinds.push_back(kind);
  }
}

Reload Reloads::draw() {
  reload_ = {};
  gateway::Settings& settings = plan_.settings;
  if (plan_.theme == Theme::busy_line) {
    draw_weights(plan_, random_);
    reload_.kinds.push_back("reload_weights");
    for (std::size_t bus = 0; bus < plan_.settings.buses.size(); ++bus) {
      reload_.touched.push_back(bus);  // who waits there has other turns now
    }
  } else if (!random_.chance(250)) {
    if (!is_guarded_ && random_.chance(400)) {
      bring_back();
    }
    const std::size_t devices = settings.devices.size();
    const std::size_t buses = settings.buses.size();
    const std::size_t listeners = settings.listeners.size();
    const std::size_t routes = settings.routes.size();
    perhaps(500, "reload_timing", devices, &Reloads::change_timing);
    perhaps(400, "reload_bus", buses, &Reloads::change_rules);
    perhaps(300, "reload_listener", listeners, &Reloads::change_listener);
    perhaps(200, "reload_idle", listeners, &Reloads::change_idle);
    perhaps(300, "reload_deadline", routes, &Reloads::change_deadline);
    perhaps(60, "reload_line", buses, &Reloads::change_line);
    if (patience_.chance(400) && change_patience(patience_.below(buses))) {
      reload_.kinds.push_back("reload_patience");
    }
    // Not so often that nothing can be told of any limit.
    if (plan_.limits_hosts && host_limits_.chance(every_ < 1s ? 30 : 300) &&
        change_host_limits(host_limits_.below(listeners))) {
      reload_.kinds.push_back("reload_host_limits");
    }
    if (is_guarded_) {  // who may write, and whether anybody is left, stays as it is
      perhaps(300, "reload_failsafe", devices, &Reloads::change_failsafe);
      if (guards_.chance(400) && change_rights(guards_.below(listeners))) {
        reload_.kinds.push_back("reload_rights");
      }
      if (guards_.chance(150) && switch_unwatched(guards_.below(devices))) {
        reload_.kinds.push_back("reload_owned_device");
      }
    } else {
      perhaps(100, "reload_rights", listeners, &Reloads::change_rights);
      perhaps(200, "reload_route", routes, &Reloads::change_route);
      perhaps(400, "reload_device", devices, &Reloads::change_device);
      perhaps(60, "reload_route_gone", routes, &Reloads::switch_route);
      perhaps(100, "reload_route_turned", routes, &Reloads::turn_route);
      perhaps(60, "reload_device_gone", devices, &Reloads::switch_device);
      perhaps(30, "reload_bus_gone", buses, &Reloads::switch_bus);
      perhaps(30, "reload_listener_gone", listeners, &Reloads::switch_listener);
      perhaps(30, "reload_allow", listeners, &Reloads::switch_allowed);
      if (plan_.moves_windows && move_windows(windows_.below(routes))) {
        reload_.kinds.push_back("reload_windows");
      }
    }
    refresh_doors();
    note_changed();
  }
  arrangement_ = random_.chance(700) ? Arrangement(plan_, random_) : Arrangement(plan_);
  return std::move(reload_);
}

Reload Reloads::restore() {
  reload_ = {};
  bring_back();
  for (gateway::ListenerSettings& listener : plan_.settings.listeners) {
    listener.max_connects_per_second = listener.max_requests_per_second = 0;
  }
  refresh_doors();
  note_changed();
  arrangement_ = Arrangement(plan_, random_);
  return std::move(reload_);
}

// A door of the device, or one whose unit leads to it at present, or may.
bool Reloads::leads_to(const Door& door, std::size_t device) const {
  return std::ranges::any_of(plan_.doors, [&](const Door& other) {
    return other.listener == door.listener && other.unit == door.unit &&
           (other.device == device ||
            (other.route && plan_.settings.routes[*other.route].device == device));
  });
}

bool Reloads::are_settled(std::size_t device) const {
  return std::ranges::all_of(plan_.doors, [&](const Door& door) {
    return !leads_to(door, device) || oracle_.is_settled(door);
  });
}

bool Reloads::are_within(std::size_t device) const {
  return std::ranges::all_of(plan_.doors, [&](const Door& door) {
    return !leads_to(door, device) || oracle_.is_within(door);
  });
}

bool Reloads::is_sure(std::size_t bus) const {
  return std::ranges::none_of(plan_.doors, [&](const Door& door) {
    return std::ranges::find(door.buses, bus) != door.buses.end() && oracle_.is_unsure(door);
  });
}

std::vector<Reloads::Meaning> Reloads::meanings() const {
  std::vector<Meaning> meanings;
  for (std::size_t index = 0; index < plan_.settings.devices.size(); ++index) {
    const drive::Device& device = plan_.settings.devices[index];
    const std::uint8_t address = plan_.absent.devices[index] ? std::uint8_t{0} : device.address;
    meanings.push_back({address, device.word_order, device.profile.limits});
  }
  return meanings;
}

// What was changed back again is as it was.
void Reloads::note_changed() {
  const auto before = std::exchange(meanings_, meanings());
  for (std::size_t index = 0; index < meanings_.size(); ++index) {
    if (meanings_[index] != before[index]) {
      const auto bus = static_cast<std::size_t>(plan_.settings.devices[index].bus);
      reload_.changed.emplace_back(bus, before[index].address);
      reload_.changed.emplace_back(bus, meanings_[index].address);
    }
  }
  std::erase_if(reload_.changed, [](const auto& place) { return place.second == 0; });
}

// What doors say follows from the settings.
void Reloads::refresh_doors() {
  for (std::size_t place = 0; place < plan_.doors.size(); ++place) {
    Door& door = plan_.doors[place];
    const auto is_absent = [&](std::size_t bus) { return plan_.absent.buses[bus]; };
    door.absent = door.route && plan_.absent.routes[*door.route];
    if (door.device) {
      const drive::Device& device = plan_.settings.devices[*door.device];
      door.absent = door.absent || plan_.absent.devices[*door.device];
      if (door.in_range) {
        const routing::Route& route = plan_.settings.routes[*door.route];
        const int unit = route.first_unit + device.address - route.first_address;
        door.absent = door.absent || unit < route.first_unit || unit > route.last_unit;
        door.unit = static_cast<std::uint8_t>(door.absent ? kUnitOfNobody : unit);
      } else if (door.route) {
        door.absent = door.absent || plan_.settings.routes[*door.route].device != door.device;
        const auto& order = plan_.settings.routes[*door.route].word_order;
        door.names_order = order.has_value();
        door.swapped = order && *order != *device.word_order;
        door.read_only = plan_.settings.routes[*door.route].access == routing::Access::read_only;
      } else {
        door.unit = device.address;
      }
    } else {
      door.buses.clear();
      std::ranges::remove_copy_if(buses_of_[place], std::back_inserter(door.buses), is_absent);
      door.absent = door.absent || door.buses.empty();
    }
    set_deadlines(plan_, door);
  }
  for (Door& door : plan_.doors) {
    door.absent = door.absent || is_hidden(plan_, door);
  }
}

}  // namespace mbgate::soak
