// SPDX-License-Identifier: Apache-2.0
// Routes of one listener beside those of all, for the same units: they go before these, and lead
// elsewhere, or let nobody write. With a chance of their own, so that plants and clients stay those
// of the seed.
#include <algorithm>
#include <iterator>

#include "soak/plan.hpp"

namespace mbgate::soak {
namespace {

constexpr std::uint64_t kRoutesChance = 0x4F574E525445ULL;

class OwnRoutes {
 public:
  OwnRoutes(SoakPlan& plan, std::uint64_t seed) : plan_(plan), random_(seed ^ kRoutesChance) {}

  void draw() {
    if (plan_.theme != Theme::none || !random_.chance(350)) {
      return;
    }
    const auto plants = std::ranges::count_if(plan_.settings.listeners,
                                              [](const auto& listener) { return !listener.bus; });
    listener_ = random_.below(static_cast<std::size_t>(plants));
    const auto watched = watched_device();
    if (watched && random_.chance(700)) {
      only_show(*watched);
    } else {
      lead_elsewhere();
    }
    hide();
  }

 private:
  [[nodiscard]] std::optional<std::size_t> watched_device();
  [[nodiscard]] bool is_watched(std::size_t device) const {
    return !plan_.failsafe[device].empty();
  }
  void only_show(std::size_t device);
  void lead_elsewhere();
  void add(std::uint8_t unit, std::size_t device, routing::Access access);
  void show_all(Door door);
  // As they are now: doors come to them.
  [[nodiscard]] std::vector<Door> doors() const {
    std::vector<Door> doors;
    std::ranges::copy_if(plan_.doors, std::back_inserter(doors), [&](const Door& door) {
      return door.listener == listener_ && door.route && !door.absent;
    });
    return doors;
  }
  void hide();

  SoakPlan& plan_;
  Random random_;
  std::size_t listener_ = 0;
};

// One that is written to when nobody is left who may.
std::optional<std::size_t> OwnRoutes::watched_device() {
  std::vector<std::size_t> watched;
  for (std::size_t device = 0; device < plan_.failsafe.size(); ++device) {
    if (is_watched(device)) {
      watched.push_back(device);
    }
  }
  return watched.empty() ? std::nullopt : std::optional(watched[random_.below(watched.size())]);
}

// Who is there may read the device, by each of its units, and nothing else.
void OwnRoutes::only_show(std::size_t device) {
  const auto bus = static_cast<std::size_t>(plan_.settings.devices[device].bus);
  for (const Door& door : doors()) {
    if (door.device == device) {
      add(door.unit, device, routing::Access::read_only);
    } else if (!door.device && !door.only_autonics &&
               std::ranges::find(door.buses, bus) != door.buses.end()) {
      show_all(door);
    }
  }
}

// To another device than any other route of the unit, so that it means something else. Whether its
// clients may write to one that is watched changes with no reload; of the units of a range nobody
// here knows which lead to an address without a device.
void OwnRoutes::lead_elsewhere() {
  for (const Door& door : doors()) {
    if (!door.device || door.in_range || !random_.chance(250)) {
      continue;
    }
    const auto access =
        random_.chance(200) ? routing::Access::read_only : routing::Access::read_write;
    const auto device = random_.below(plan_.settings.devices.size());
    const bool is_led_to = std::ranges::any_of(plan_.doors, [&](const Door& other) {
      return other.listener == listener_ && other.unit == door.unit && other.device == device;
    });
    if (!is_led_to && (is_watched(device) || !is_watched(*door.device))) {
      add(door.unit, device, access);
    }
  }
}

void OwnRoutes::add(std::uint8_t unit, std::size_t device, routing::Access access) {
  const drive::Device& led_to = plan_.settings.devices[device];
  routing::Route& route = plan_.settings.routes.emplace_back();
  route.listener = gateway::ListenerId{static_cast<std::uint32_t>(listener_)};
  route.first_unit = route.last_unit = unit;
  route.buses = {led_to.bus};
  route.first_address = led_to.address;
  route.device = device;
  route.access = access;
  Door door{listener_, unit, device, {static_cast<std::size_t>(led_to.bus)}};
  door.routed = true;
  door.read_only = access == routing::Access::read_only;
  door.route = plan_.settings.routes.size() - 1;
  plan_.absent.routes.push_back(false);
  plan_.doors.push_back(door);
}

// Address 129 follows the route to all.
void OwnRoutes::show_all(Door door) {
  routing::Route route = plan_.settings.routes[*door.route];
  route.listener = gateway::ListenerId{static_cast<std::uint32_t>(listener_)};
  route.access = routing::Access::read_only;
  plan_.settings.routes.push_back(route);
  plan_.absent.routes.push_back(false);
  door.route = plan_.settings.routes.size() - 1;
  door.read_only = true;
  for (Door& other : plan_.doors) {
    if (other.listener == listener_ && other.only_autonics) {
      other.read_only = true;
    }
  }
  plan_.doors.push_back(door);
}

void OwnRoutes::hide() {
  for (Door& door : plan_.doors) {
    door.absent = door.absent || is_hidden(plan_, door);
  }
}

}  // namespace

bool is_hidden(const SoakPlan& plan, const Door& door) {
  const auto& routes = plan.settings.routes;
  return door.route && !door.only_autonics && !routes[*door.route].listener &&
         std::ranges::any_of(plan.doors, [&](const Door& other) {
           return other.listener == door.listener && other.unit == door.unit && !other.absent &&
                  other.route && routes[*other.route].listener;
         });
}

void draw_own_routes(SoakPlan& plan, std::uint64_t seed) { OwnRoutes(plan, seed).draw(); }

}  // namespace mbgate::soak
