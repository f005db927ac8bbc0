// SPDX-License-Identifier: Apache-2.0
// The listeners and routes of a plant: through which units clients reach its drives.
#include <algorithm>
#include <string>

#include "world/plan.hpp"

namespace mbgate::world {

namespace {

constexpr std::uint64_t kRangesChance = 0x52414E47ULL;
constexpr std::uint64_t kFormsChance = 0x464F524DULL;
constexpr std::uint64_t kGapsChance = 0x47415053ULL;
constexpr std::uint64_t kTimeoutsChance = 0x54494D45ULL;

void add_listeners(Plan& plan, Random& random) {
  auto& listeners = plan.settings.listeners;
  for (unsigned count = random.between(1U, 2U); count > 0; --count) {
    listeners.emplace_back().name = "plant-" + std::to_string(count);
  }
  for (std::size_t bus = 0; bus < plan.lines.size(); ++bus) {
    auto& listener = listeners.emplace_back();
    listener.name = "straight-" + std::to_string(bus);
    listener.bus = drive::BusId{static_cast<std::uint32_t>(bus)};
    listener.broadcast = !plan.is_tcp(bus);
  }
  for (auto& listener : listeners) {
    listener.pipeline = random.one_of<std::size_t>({1, 4, 16, 64});
    listener.ordered = random.chance(250);
    if (random.chance(200)) {
      listener.max_connections = random.one_of<std::size_t>({1, 2, 4, 8});
    }
    if (random.chance(200)) {
      listener.max_connections_per_address = random.one_of<std::size_t>({1, 2, 3});
    }
    if (random.chance(150)) {
      listener.max_requests_per_second = random.between(20U, 200U);
    }
    listener.max_connects_per_second = random.chance(100) ? 5 : 0;
    if (random.chance(200)) {
      listener.idle_timeout = random.duration(300ms, 3s);
    }
    listener.frame_timeout = random.duration(1s, 10s);
    std::vector<unsigned>& readers = plan.readers.emplace_back();
    for (unsigned host = 0; host < kMostHosts; ++host) {
      if (random.chance(60)) {
        readers.push_back(host);
      }
    }
    listener.read_only = networks_of(readers);
  }
}

// What the gateway knows of the timeouts of a listener's clients.
void draw_timeouts(Plan& plan) {
  Random random(plan.seed ^ kTimeoutsChance);
  for (auto& listener : plan.settings.listeners) {
    listener.give_up = random.chance(120) ? random.duration(500ms, 3s) : 0ms;
    listener.one_at_a_time = random.chance(120);
  }
}

void set_windows(routing::Route& route, Door& door, Random& random) {
  constexpr unsigned kMiddle = kTableEnd / 2;
  door.windowed = true;
  door.holding_at = random.one_of({0U, random.between(1U, kMiddle - kRegisters)});
  door.input_at =
      random.one_of({kTableEnd - kInputs, random.between(kMiddle, kTableEnd - kInputs)});
  const auto word = [](unsigned value) { return static_cast<std::uint16_t>(value); };
  route.windows = {
      {Table::holding_registers, word(door.holding_at), kRegisters, Table::holding_registers, 0},
      {Table::holding_registers, word(door.input_at), kInputs, Table::input_registers, 0},
      {Table::coils, 0, kCoils, Table::coils, 0}};
  route.functions = routing::FunctionRules::rewritable();
}

void add_to_routed(Plan& plan, Door door) {
  for (door.listener = 0; !plan.settings.listeners[door.listener].bus; ++door.listener) {
    plan.doors.push_back(door);
  }
}

void add_route(Plan& plan, std::size_t at, std::uint8_t unit, Random& random) {
  const Station& station = plan.stations[at];
  const drive::Device& device = *plan.device_of(station);
  auto& route = plan.settings.routes.emplace_back();
  route.first_unit = route.last_unit = unit;
  route.buses = {device.bus};
  route.first_address = station.address;
  route.device = station.device;
  if (random.chance(600)) {
    route.word_order = random.one_of({drive::WordOrder::big, drive::WordOrder::little});
  }
  route.access = random.chance(100) ? routing::Access::read_only : routing::Access::read_write;
  if (!plan.default_times && random.chance(500)) {
    route.deadline = random.duration(50ms, 3s);
  }
  Door door;
  door.unit = unit;
  door.station = at;
  door.route = plan.settings.routes.size() - 1;
  door.routed = true;
  if (random.chance(300)) {
    set_windows(route, door, random);
  }
  door.swapped = route.word_order && *route.word_order != *device.word_order;
  door.read_only = route.access == routing::Access::read_only;
  add_to_routed(plan, door);
}

// A range of units, each an address of the bus: nothing is exchanged or split.
void add_range(Plan& plan, std::size_t bus) {
  constexpr unsigned kFirst = 100;
  constexpr unsigned kCount = 40;
  Random random(plan.seed ^ (kRangesChance + bus));
  const unsigned from = random.between(1U, 3U);
  const unsigned first = kFirst + kCount * static_cast<unsigned>(bus);
  const bool has_addresses = std::ranges::any_of(plan.stations, [&](const Station& it) {
    return it.bus == bus && !it.every_unit && it.address >= from;
  });
  if (!random.chance(300) || !has_addresses) {
    return;
  }
  auto& route = plan.settings.routes.emplace_back();
  route.first_unit = low(first);
  route.last_unit = low(first + kCount - 1);
  route.buses = {drive::BusId{static_cast<std::uint32_t>(bus)}};
  route.first_address = low(from);
  for (std::size_t at = 0; at < plan.stations.size(); ++at) {
    const Station& station = plan.stations[at];
    if (station.bus == bus && station.address >= from && station.address < from + kCount) {
      Door door;
      door.unit = low(first + station.address - from);
      door.station = at;
      door.route = plan.settings.routes.size() - 1;
      add_to_routed(plan, door);
    }
  }
}

void add_broadcasts(Plan& plan, Random& random) {
  Door all;
  auto& route = plan.settings.routes.emplace_back();
  for (std::size_t bus = 0; bus < plan.lines.size(); ++bus) {
    if (!plan.is_tcp(bus)) {
      all.buses.push_back(bus);
      route.buses.push_back(drive::BusId{static_cast<std::uint32_t>(bus)});
    }
  }
  if (all.buses.empty()) {
    plan.settings.routes.pop_back();
    return;
  }
  route.broadcast_reply =
      random.chance(700) ? routing::BroadcastReply::echo : routing::BroadcastReply::none;
  route.broadcast_mixed = random.chance(500);
  all.replies = route.broadcast_reply == routing::BroadcastReply::echo;
  all.route = plan.settings.routes.size() - 1;
  add_to_routed(plan, all);
}

}  // namespace

// On a line of a plant where any is, about half of the drives are such.
void draw_forms(Plan& plan) {
  Random random(plan.seed ^ kFormsChance);
  const bool has_some = random.chance(200);
  for (Station& station : plan.stations) {
    if (has_some && !plan.is_tcp(station.bus) && random.chance(500)) {
      station.other_broadcasts = true;
      plan.settings.devices[*station.device].profile.broadcast.form =
          drive::BroadcastForm{129, 0x80};
    }
  }
}

// A quarter of the drives of such a plant must be left alone after each write.
void draw_gaps(Plan& plan) {
  Random random(plan.seed ^ kGapsChance);
  const bool has_some = random.chance(200);
  for (const Station& station : plan.stations) {
    const bool is_one = random.chance(250);
    const Duration gap = random.duration(2ms, 40ms);
    plan.settings.devices[*station.device].timing.gap_after_write = has_some && is_one ? gap : 0ms;
  }
}

void draw_doors(Plan& plan, Random& random) {
  draw_forms(plan);
  draw_gaps(plan);
  add_listeners(plan, random);
  draw_timeouts(plan);
  unsigned unit = 1;
  for (std::size_t at = 0; at < plan.stations.size(); ++at) {
    for (unsigned count = random.between(1U, 2U); count > 0; --count) {
      add_route(plan, at, low(unit++), random);
    }
    const Station& station = plan.stations[at];
    for (std::size_t listener = 0; listener < plan.settings.listeners.size(); ++listener) {
      const auto bus = plan.settings.listeners[listener].bus;
      if (bus && static_cast<std::size_t>(*bus) == station.bus) {
        Door door;
        door.listener = listener;
        door.unit = station.every_unit ? low(random.between(1U, 247U)) : station.address;
        door.station = at;
        plan.doors.push_back(door);
      }
    }
  }
  for (std::size_t bus = 0; bus < plan.lines.size(); ++bus) {
    add_range(plan, bus);
  }
  add_broadcasts(plan, random);
}

}  // namespace mbgate::world
