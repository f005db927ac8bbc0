// SPDX-License-Identifier: Apache-2.0
#include "simulation/world.hpp"

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

}  // namespace

World::World(const gateway::Settings& settings,
             const std::vector<std::vector<sim::DeviceSettings>>& devices, OnAnswer on_answer)
    : on_answer_(std::move(on_answer)), harness_(settings, Instant{1s}) {
  for (std::size_t bus = 0; bus < devices.size(); ++bus) {
    wires_.emplace_back(wire_for(settings.buses[bus]), devices[bus]);
  }
  drain();
}

ClientId World::connect(std::size_t listener, unsigned host) {
  const ClientId client{++clients_};
  const auto address = routing::ClientAddress::parse("10.0." + std::to_string(host / 250) + "." +
                                                     std::to_string(host % 250 + 1));
  feed(gateway::ClientConnected{
      client, {gateway::ListenerId{static_cast<std::uint32_t>(listener)}, *address}});
  return client;
}

void World::send(ClientId client, modbus::Bytes bytes) {
  feed(gateway::ClientBytes{client, bytes});
}

std::optional<Instant> World::next_event() const {
  const auto wake = harness_.next_wake();
  auto next = wake ? std::optional(wake->at) : std::nullopt;
  for (const sim::Wire& wire : wires_) {
    next = bus::earlier(next, wire.next_event());
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
    for (std::size_t bus = 0; bus < wires_.size(); ++bus) {
      const auto bytes = wires_[bus].advance(now());
      if (!bytes.empty()) {
        feed(gateway::LineBytes{BusId{static_cast<std::uint32_t>(bus)}, bytes});
      }
    }
    feed(gateway::DeadlineReached{});
  }
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
    wires_[bus].transmit({transmit->frame.data(), transmit->frame.size()}, now());
  } else if (const auto* look = std::get_if<gateway::Look>(&action)) {
    harness_.handle(gateway::LineLooked{look->bus});
  } else if (const auto* open = std::get_if<gateway::Open>(&action)) {
    harness_.handle(gateway::LineOpened{open->bus});
  }
}

std::uint64_t World::silence_violations() const {
  std::uint64_t total = 0;
  for (const sim::Wire& wire : wires_) {
    total += wire.counters().silence_violations;
  }
  return total;
}

}  // namespace mbgate::test
