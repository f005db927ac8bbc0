// SPDX-License-Identifier: Apache-2.0
// The listeners and routes of one seed: through which units clients reach its devices.
#include <string>

#include "soak/plan.hpp"
#include "soak/registers.hpp"

namespace mbgate::soak {
namespace {

using namespace std::chrono_literals;
using drive::WordOrder;

constexpr int kLastUnit = 200;

class Doors {
 public:
  Doors(SoakPlan& plan, Random& random) : plan_(plan), random_(random) {}

  void add() {
    add_listeners();
    plan_.absent.listeners.resize(plan_.settings.listeners.size());
    plan_.absent.buses.resize(plan_.settings.buses.size());
    plan_.absent.devices.resize(plan_.settings.devices.size());
    add_doors();
    plan_.absent.routes.resize(plan_.settings.routes.size());
  }

 private:
  void add_listeners();
  void add_doors();
  void add_routes(std::size_t device);
  void add_windows(routing::Route& route, Door& door);
  void add_range(std::size_t bus);
  void add_broadcasts();
  [[nodiscard]] bool is_tcp(std::size_t bus) const {
    return plan_.settings.buses[bus].line.framing == bus::Framing::tcp;
  }

  SoakPlan& plan_;
  Random& random_;
  std::uint8_t next_unit_ = 1;
};

void Doors::add_listeners() {
  auto& listeners = plan_.settings.listeners;
  for (unsigned count = random_.between(1U, 2U); count > 0; --count) {
    listeners.emplace_back().name = "plant-" + std::to_string(count);
  }
  for (std::size_t bus = 0; bus < plan_.settings.buses.size(); ++bus) {
    auto& listener = listeners.emplace_back();
    listener.name = "straight-" + std::to_string(bus);
    listener.bus = drive::BusId{static_cast<std::uint32_t>(bus)};
    listener.broadcast = true;
    listener.broadcast_reply =
        random_.chance(700) ? routing::BroadcastReply::echo : routing::BroadcastReply::none;
  }
  for (auto& listener : listeners) {
    listener.pipeline = random_.one_of<std::size_t>({1, 4, 16, 64});
    listener.ordered = random_.chance(250);
    listener.max_connections = listener.max_connections_per_address = 1000;
    listener.max_connects_per_second = listener.max_requests_per_second = 0;
  }
}

void Doors::add_doors() {
  auto& settings = plan_.settings;
  for (std::size_t index = 0; index < settings.devices.size(); ++index) {
    add_routes(index);
    const auto bus = static_cast<std::size_t>(settings.devices[index].bus);
    for (std::size_t listener = 0; listener < settings.listeners.size(); ++listener) {
      if (settings.listeners[listener].bus == settings.devices[index].bus) {
        Door door{listener, settings.devices[index].address, index, {bus}};
        plan_.doors.push_back(door);
      }
    }
  }
  for (std::size_t bus = 0; bus < settings.buses.size(); ++bus) {
    if (random_.chance(300)) {
      add_range(bus);
    }
  }
  add_broadcasts();
}

void Doors::add_routes(std::size_t index) {
  const drive::Device& device = plan_.settings.devices[index];
  for (unsigned count = random_.between(1U, 2U); count > 0; --count) {
    auto& route = plan_.settings.routes.emplace_back();
    route.first_unit = route.last_unit = next_unit_++;
    route.buses = {device.bus};
    route.first_address = device.address;
    route.device = index;
    if (random_.chance(600)) {
      route.word_order = random_.one_of({WordOrder::big, WordOrder::little});
    }
    route.access = random_.chance(100) ? routing::Access::read_only : routing::Access::read_write;
    if (random_.chance(500)) {
      route.deadline = random_.duration(50ms, 3s);
    }
    Door door{0, route.first_unit, index, {static_cast<std::size_t>(device.bus)}};
    door.routed = true;
    if (random_.chance(300)) {
      add_windows(route, door);
    }
    door.names_order = route.word_order.has_value();
    door.swapped = route.word_order && *route.word_order != *device.word_order;
    door.read_only = route.access == routing::Access::read_only;
    door.route = plan_.settings.routes.size() - 1;
    const bool has_twin = index > 0 && random_.chance(300);
    const std::size_t other = has_twin ? random_.below(index) : 0;
    for (; !plan_.settings.listeners[door.listener].bus; ++door.listener) {
      plan_.doors.push_back(door);
      if (has_twin) {
        add_twin(plan_, door, other);
      }
    }
  }
}

// Anywhere, up to the last address; input registers are shown as holding registers.
void Doors::add_windows(routing::Route& route, Door& door) {
  constexpr unsigned kEnd = kAddresses;
  constexpr unsigned kMiddle = kEnd / 2;
  door.windowed = true;
  door.holding_at = random_.one_of({0U, random_.between(1U, kMiddle - kRegisters)});
  door.input_at = random_.one_of({kEnd - kInputs, random_.between(kMiddle, kEnd - kInputs)});
  door.shows_coils = random_.chance(500);
  if (door.shows_coils) {
    door.coils_at = random_.one_of({kEnd - kCoils, random_.between(0U, kEnd - kCoils)});
  }
  set_windows(route, door);
  route.functions = routing::FunctionRules::rewritable();
}

// One route to all addresses of a bus that a device has, and those between.
void Doors::add_range(std::size_t bus) {
  std::vector<std::size_t> on_it;
  for (std::size_t index = 0; index < plan_.settings.devices.size(); ++index) {
    if (static_cast<std::size_t>(plan_.settings.devices[index].bus) == bus) {
      on_it.push_back(index);
    }
  }
  const std::uint8_t first = plan_.settings.devices[on_it.front()].address;
  const std::uint8_t last = plan_.settings.devices[on_it.back()].address;
  if (next_unit_ + last > kLastUnit + first) {
    return;
  }
  auto& route = plan_.settings.routes.emplace_back();
  route.first_unit = next_unit_;
  route.last_unit = static_cast<std::uint8_t>(next_unit_ + (last - first));
  next_unit_ = static_cast<std::uint8_t>(route.last_unit + 1);
  route.buses = {drive::BusId{static_cast<std::uint32_t>(bus)}};
  route.first_address = first;
  for (const std::size_t index : on_it) {
    const std::uint8_t address = plan_.settings.devices[index].address;
    Door door{0, static_cast<std::uint8_t>(route.first_unit + (address - first)), index, {bus}};
    door.route = plan_.settings.routes.size() - 1;
    door.in_range = true;
    for (; !plan_.settings.listeners[door.listener].bus; ++door.listener) {
      plan_.doors.push_back(door);
    }
  }
}

void Doors::add_broadcasts() {
  auto& settings = plan_.settings;
  Door all;
  auto& route = settings.routes.emplace_back();
  for (std::size_t bus = 0; bus < settings.buses.size(); ++bus) {
    if (!is_tcp(bus)) {
      all.buses.push_back(bus);
      route.buses.push_back(drive::BusId{static_cast<std::uint32_t>(bus)});
    }
  }
  route.broadcast_reply =
      random_.chance(700) ? routing::BroadcastReply::echo : routing::BroadcastReply::none;
  all.replies = route.broadcast_reply == routing::BroadcastReply::echo;
  all.route = settings.routes.size() - 1;
  if (all.buses.empty()) {
    settings.routes.pop_back();
    return;
  }
  for (; !settings.listeners[all.listener].bus; ++all.listener) {
    plan_.doors.push_back(all);
  }
  for (std::size_t at = 0; at < settings.listeners.size(); ++at) {
    const auto& listener = settings.listeners[at];
    if (listener.bus && !is_tcp(static_cast<std::size_t>(*listener.bus))) {
      Door door{at, 0, std::nullopt, {static_cast<std::size_t>(*listener.bus)}};
      door.replies = listener.broadcast_reply == routing::BroadcastReply::echo;
      plan_.doors.push_back(door);
    }
  }
}

}  // namespace

void set_windows(routing::Route& route, const Door& door) {
  route.windows = {{Table::holding_registers, static_cast<std::uint16_t>(door.holding_at),
                    kRegisters, Table::holding_registers, 0},
                   {Table::holding_registers, static_cast<std::uint16_t>(door.input_at), kInputs,
                    Table::input_registers, 0}};
  if (door.shows_coils) {
    route.windows.push_back(
        {Table::coils, static_cast<std::uint16_t>(door.coils_at), kCoils, Table::coils, 0});
  }
}

void draw_doors(SoakPlan& plan, Random& random) { Doors(plan, random).add(); }

}  // namespace mbgate::soak
