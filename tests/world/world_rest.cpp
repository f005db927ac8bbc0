// SPDX-License-Identifier: Apache-2.0
// The calm end: nothing goes wrong any more, and everything must come back.
#include "world/world.hpp"

namespace mbgate::world {

void World::come_to_rest() {
  ledger_.calm = true;
  driver_.calm_down();
  for (Client& client : clients_) {
    client.end_asking();
    client.end_stall();
  }
  for (Wire& wire : wires_) {
    std::visit([](auto& it) { it.calm_down(); }, wire);
  }
  for (Drive& drive : drives_) {
    drive.calm_down();
  }
  for (const Station& station : plan_.stations) {
    if (station.drives.size() > 1) {
      drives_[station.drives.back()].habits.dead = true;  // two at one address are never well
    }
  }
  run_for(60s);
  if (plan_.reloads_every > Duration{0}) {
    rename_devices();
    run_for(1s);
  }
  ledger_.rested = schedule_.now();
  for (Client& client : clients_) {
    client.leave();
  }
  // Of a storm of stops hundreds may wait, each with its tries.
  constexpr unsigned kMostWaits = 100;
  std::size_t sent = 0;
  for (unsigned waits = 0; waits < kMostWaits && sent != ledger_.sent.size(); ++waits) {
    sent = ledger_.sent.size();
    run_for(10s);
  }
}

std::optional<Octets> World::ask(std::size_t door, Duration patience) {
  return ask(plan_.doors[door].listener, asking_.fresh_read(door), patience);
}

std::optional<Octets> World::ask_gateway(const Octets& pdu, Duration patience) {
  return ask(0, Asking::of_gateway(pdu), patience);
}

Client& World::visit(std::size_t listener, unsigned host) {
  Manners manners;
  manners.listener = listener;
  manners.host = host;
  Client& client = clients_.emplace_back(manners, tools_);
  client.end_asking();
  client.connect();
  return client;
}

std::optional<Octets> World::ask(std::size_t listener, Intent intent, Duration patience) {
  Client& client = visit(listener, kMostHosts - 1);
  if (!client.is_connected()) {
    run_for(patience);
    return std::nullopt;
  }
  const Id id = client.write(std::move(intent));
  run_for(patience);
  const Asked& asked = ledger_.asked[id];
  const bool is_answered = asked.answers > 0;
  const Octets answer = asked.answer;
  client.leave();
  return is_answered ? std::optional(answer) : std::nullopt;
}

void World::shut_down() {
  ledger_.stopping = schedule_.now();
  driver_.end_stops();
  trace("shut down");
  hand_in(gateway::ShutdownAsked{});
  run_for(2200ms);
}

}  // namespace mbgate::world
