// SPDX-License-Identifier: Apache-2.0
// The settings that the machine is fuzzed with: a line in RTU, one in ASCII, a Modbus TCP server;
// drives with values, stops and restarts; listeners of every kind.
#pragma once

#include "gateway/settings.hpp"
#include "modbus/request.hpp"

namespace mbgate::fuzz {

/// The bits of `choices` turn single rules on.
inline gateway::Settings plant(std::uint16_t choices) {
  using namespace std::chrono_literals;
  using modbus::Table;
  gateway::Settings settings;
  const auto chosen = [&](unsigned bit) { return ((choices >> bit) & 1U) != 0; };
  for (std::uint32_t index = 0; index < 3; ++index) {
    auto& bus = settings.buses.emplace_back();
    bus.name = "bus-" + std::to_string(index);
    bus.line.device = "/dev/ttyS0";
    bus.timing.response_timeout = 100ms;
    bus.queue = chosen(0) ? 4 : 2048;
    bus.coalesce = !chosen(1);
    bus.settle = chosen(3) ? 10ms : 0ms;
    bus.line.echo = index == 0 && chosen(4);
    auto& drive = settings.devices.emplace_back();
    drive.name = "drive-" + std::to_string(index);
    drive.bus = drive::BusId{index};
    drive.timing.response_timeout = 50ms;
    drive.timing.gap = chosen(5) ? 5ms : 0ms;
    drive.timing.retry_writes = chosen(6);
    drive.cache = chosen(7) ? 50ms : 0ms;
    drive.word_order = drive::WordOrder::little;
    drive.profile.values.add({Table::holding_registers, 4, 2, false});
    drive.profile.values.add({Table::holding_registers, 8, 4, true});
    drive.profile.limits.read[2] = 8;
    drive.profile.stops.push_back({Table::holding_registers, 0x7C, 0xFFFF, 0xE1});
    drive.profile.unanswered.push_back({{Table::holding_registers, 0x80}, 200ms});
    auto& guard = settings.guards.emplace_back();
    guard.writer = chosen(8) ? gateway::WriterRule::first : gateway::WriterRule::any;
    if (chosen(9)) {
      guard.failsafe.push_back(modbus::make_single_write(Table::holding_registers, 0x7C, 0xE1));
      guard.quiet = 2s;
    }
    auto& route = settings.routes.emplace_back();
    route.first_unit = route.last_unit = static_cast<std::uint8_t>(1 + index);
    route.first_address = drive.address;
    route.buses = {drive.bus};
    route.device = index;
    route.word_order = drive::WordOrder::big;
  }
  settings.buses[1].line.framing = bus::Framing::ascii;
  settings.buses[2].line.framing = bus::Framing::tcp;
  settings.buses[2].line.remote = bus::Endpoint{"192.0.2.9", 502};
  settings.buses[2].outstanding = 3;
  auto& broadcast = settings.routes.emplace_back();
  broadcast.buses = {drive::BusId{0}, drive::BusId{1}};
  for (std::uint32_t index = 0; index < 4; ++index) {
    auto& listener = settings.listeners.emplace_back();
    listener.name = "listener-" + std::to_string(index);
    listener.pipeline = 3;
    listener.max_connections = 4;
    listener.ordered = index == 1;
    listener.max_connections_per_address = index == 3 ? 2 : 4;
    listener.max_connects_per_second = index == 3 ? 2 : 100;
    listener.max_requests_per_second = index >= 1 && index <= 2 ? 20 : 0;
    listener.idle_timeout = index == 1 ? 30s : 0s;
    if (index >= 2) {
      listener.bus = drive::BusId{index - 2};
      listener.broadcast = index == 2;
    }
  }
  return settings;
}

}  // namespace mbgate::fuzz
