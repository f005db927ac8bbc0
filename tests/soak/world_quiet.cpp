// SPDX-License-Identifier: Apache-2.0
// The quiet phase: nothing goes wrong any more, and everything must be well again.
#include "soak/world.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

namespace {

constexpr Duration kQuiet = 60s;
constexpr Duration kAlone = 15s;  // until failsafe writes are sent
constexpr Duration kUntilStopped = 2200ms;

}  // namespace

// Nothing goes wrong any more, and nobody asks for anything new.
void World::calm_down() {
  trouble_ = false;
  driver_.calm_down();
  for (Wire& wire : wires_) {
    std::visit([](auto& it) { it.calm_down(); }, wire);
  }
  for (SoakDevice& device : devices_) {
    device.revive();
  }
  for (Client& client : clients_) {
    client.end_asking();
    client.end_stall();
  }
}

// Nothing goes wrong any more until everything is over; then all must be well again.
void World::come_to_rest() {
  calm_down();
  const Instant latest = schedule_.now() + kStopLife;
  do {
    run_until(schedule_.now() + kQuiet);
  } while (oracle_.has_stops() && schedule_.now() < latest);
  for (Client& client : clients_) {
    client.leave();
  }
  run_until(schedule_.now() + kAlone);
  restore();
  if (!stuck_) {
    oracle_.check_finished();
    check_back();
    run_until(schedule_.now() + kAlone);
    check_counters();
  }
}

// Everything goes on as before, and goes wrong, but that the gateway stops.
void World::shut_down() {
  trace("shut down");
  driver_.end_stops();
  is_stopping_ = true;
  end_ = schedule_.now() + kGrace;
  oracle_.begin_shutdown();
  harness_.handle(gateway::ShutdownAsked{}, schedule_.now());
  drain();
  run_until(schedule_.now() + kUntilStopped);
  oracle_.check_stopped();
}

// Every device answers within its probe interval, and rightly.
void World::check_back() {
  constexpr int kTries = 20;
  for (const Door& door : plan_.doors) {
    if (!door.device || door.absent || !plan_.settings.listeners[door.listener].bus) {
      continue;
    }
    Manners manners;
    manners.listener = door.listener;
    Client& client = clients_.emplace_back(manners, tools_);
    client.end_asking();
    const auto& line = plan_.settings.buses[door.buses.front()].line;
    const bool is_slow = line.baud < modbus::Baud{9600};
    const Duration patience = is_slow ? 2s : 500ms;
    bool well = false;
    for (int tries = 0; tries < kTries && !well; ++tries) {
      client.connect();  // it was perhaps closed because it was idle
      if (!client.is_connected()) {
        break;
      }
      const std::uint64_t id = client.write(asking_.fresh_read(door));
      run_until(schedule_.now() + patience);
      well = oracle_.was_answered_well(id);
    }
    client.leave();
    if (!well && oracle_.takes_answers_for_echoes(door.buses.front())) {
      ++report_.apart["not_back_claimed_echo"];
    } else if (!well) {
      oracle_.violation("not_back", plan_.settings.devices[*door.device].name);
    }
  }
}

}  // namespace mbgate::soak
