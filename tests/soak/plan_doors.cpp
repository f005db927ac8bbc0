// SPDX-License-Identifier: Apache-2.0
// The listeners and routes of one seed: through which units clients reach its devices.
#include <string>

#include "soak/plan.hpp"
#include "soak/registers.hpp"

namespace mbgate::soak {
namespace {

using namespace std::chrono_literals;
using drive::WordOrder;

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
    listener.max_connections = 1000;
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
        set_deadlines(plan_, door);
        plan_.doors.push_back(door);
      }
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
    if (random_.chance(300)) {
      route.windows = {
          {Table::holding_registers, kHoldingWindow, kRegisters, Table::holding_registers, 0},
          {Table::holding_registers, kInputWindow, kInputs, Table::input_registers, 0}};
      route.functions = routing::FunctionRules::rewritable();
    }
    route.access = random_.chance(100) ? routing::Access::read_only : routing::Access::read_write;
    if (random_.chance(500)) {
      route.deadline = random_.duration(50ms, 3s);
    }
    Door door{0, route.first_unit, index, {static_cast<std::size_t>(device.bus)}};
    door.routed = true;
    door.windowed = !route.windows.empty();
    door.names_order = route.word_order.has_value();
    door.swapped = route.word_order && *route.word_order != *device.word_order;
    door.read_only = route.access == routing::Access::read_only;
    door.route = plan_.settings.routes.size() - 1;
    set_deadlines(plan_, door);
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
  set_deadlines(plan_, all);
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
      set_deadlines(plan_, door);
      plan_.doors.push_back(door);
    }
  }
}

}  // namespace

void draw_doors(SoakPlan& plan, Random& random) { Doors(plan, random).add(); }

}  // namespace mbgate::soak
