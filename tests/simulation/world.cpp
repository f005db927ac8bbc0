// SPDX-License-Identifier: Apache-2.0
#include "simulation/world.hpp"

#include "base/assert.hpp"

namespace mbgate::test {
namespace {

sim::WireSettings wire_for(const bus::BusSettings& bus) {
  sim::WireSettings wire;
  wire.baud = bus.line.baud;
  wire.format = bus.line.format;
  wire.framing = bus.line.framing == bus::Framing::ascii ? sim::Framing::ascii : sim::Framing::rtu;
  wire.gap = bus.frame_gap;
  wire.echo = bus.line.echo.value_or(false);
  wire.frames_kept = 200'000;
  return wire;
}

gateway::Settings settings_for(const std::vector<BusPlan>& buses) {
  gateway::Settings settings;
  for (std::size_t index = 0; index < buses.size(); ++index) {
    const BusId bus{static_cast<std::uint32_t>(index)};
    settings.buses.push_back(buses[index].bus);
    settings.buses.back().name = "line-" + std::to_string(index);
    auto& listener = settings.listeners.emplace_back();
    listener.name = settings.buses.back().name;
    listener.bus = bus;
    listener.broadcast = true;
  }
  return settings;
}

std::vector<std::vector<sim::DeviceSettings>> devices_of(const std::vector<BusPlan>& buses) {
  std::vector<std::vector<sim::DeviceSettings>> devices;
  devices.reserve(buses.size());
  for (const BusPlan& plan : buses) {
    devices.push_back(plan.devices);
  }
  return devices;
}

}  // namespace

World::World(const std::vector<BusPlan>& buses, OnAnswer on_answer)
    : World(settings_for(buses), devices_of(buses), std::move(on_answer)) {}

World::World(const gateway::Settings& settings,
             const std::vector<std::vector<sim::DeviceSettings>>& devices, OnAnswer on_answer)
    : on_answer_(std::move(on_answer)), harness_(settings, Instant{1s}) {
  for (std::size_t bus = 0; bus < devices.size(); ++bus) {
    wires_.emplace_back(wire_for(settings.buses[bus]), devices[bus]);
    servers_.emplace_back();
    if (settings.buses[bus].line.framing == bus::Framing::tcp) {
      servers_.back().emplace(devices[bus], true);
    }
  }
  drain();
}

ClientId World::connect(std::size_t listener, unsigned host) {
  const ClientId client{++clients_};
  const auto address = routing::ClientAddress::parse("10.0." + std::to_string(host / 250) + "." +
                                                     std::to_string(host % 250 + 1));
  feed(gateway::ClientConnected{client,
                                {ListenerId{static_cast<std::uint32_t>(listener)}, *address}});
  return client;
}

void World::send(ClientId client, modbus::Bytes bytes) {
  feed(gateway::ClientBytes{client, bytes});
}

void World::disconnect(ClientId client) { feed(gateway::ClientDisconnected{client}); }

std::optional<Instant> World::next_event() const {
  const auto wake = harness_.next_wake();
  auto next = wake ? std::optional(wake->at) : std::nullopt;
  for (const sim::Wire& wire : wires_) {
    next = bus::earlier(next, wire.next_event());
  }
  for (const auto& server : servers_) {
    next = bus::earlier(next, server ? server->next_event() : std::nullopt);
  }
  return next;
}

void World::run(Instant limit, const std::function<bool()>& done) {
  while (!done()) {
    const auto next = next_event();
    if (!next || *next > limit) {
      harness_.go_on(std::max(now(), limit));
      return;
    }
    harness_.go_on(std::max(now(), *next));
    step();
  }
}

void World::step() {
  for (std::size_t bus = 0; bus < wires_.size(); ++bus) {
    const BusId number{static_cast<std::uint32_t>(bus)};
    const auto bytes = wires_[bus].advance(now());
    if (!bytes.empty()) {
      feed(gateway::LineBytes{number, bytes});
    }
    if (servers_[bus]) {
      for (const sim::TcpResponse& response : servers_[bus]->advance(now())) {
        feed(gateway::LineBytes{number, {response.bytes.data(), response.bytes.size()}});
      }
    }
  }
  feed(gateway::DeadlineReached{});
}

void World::feed(const gateway::Input& input) {
  harness_.handle(input);
  drain();
}

void World::drain() {
  harness_.drain([this](const gateway::Action& action) { take(action); });
}

void World::take(const gateway::Action& action) {
  if (const auto* send = std::get_if<gateway::Send>(&action)) {
    harness_.handle(gateway::ClientSent{send->client});
    on_answer_(send->client, {send->adu.data(), send->adu.size()});
  } else if (const auto* transmit = std::get_if<gateway::Transmit>(&action)) {
    const auto bus = static_cast<std::size_t>(transmit->bus);
    const modbus::Bytes frame(transmit->frame.data(), transmit->frame.size());
    if (servers_[bus]) {
      constexpr sim::ConnectionId kConnection = 1;
      MBGATE_ASSERT(servers_[bus]->receive(kConnection, frame, now()), "it is Modbus TCP");
    } else {
      wires_[bus].transmit(frame, now());
    }
  } else if (const auto* look = std::get_if<gateway::Look>(&action)) {
    harness_.handle(gateway::LineLooked{look->bus});
  } else if (const auto* open = std::get_if<gateway::Open>(&action)) {
    harness_.handle(gateway::LineOpened{open->bus});
  } else if (const auto* close = std::get_if<gateway::Close>(&action)) {
    closed_[close->client] = true;
  }
}

std::uint64_t World::silence_violations() const {
  std::uint64_t total = 0;
  for (const sim::Wire& wire : wires_) {
    total += wire.counters().silence_violations;
  }
  return total;
}

std::uint64_t World::collisions() const {
  std::uint64_t total = 0;
  for (const sim::Wire& wire : wires_) {
    total += wire.counters().collisions;
  }
  return total;
}

}  // namespace mbgate::test
