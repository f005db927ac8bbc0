// SPDX-License-Identifier: Apache-2.0
// The quiet phase: nothing goes wrong any more, and everything must be well again.
#include "soak/world.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

// Nothing goes wrong any more, and nobody asks for anything new.
void World::calm_down() {
  trouble_ = false;
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

// Every device answers within its probe interval, and rightly.
void World::check_back() {
  constexpr int kTries = 20;
  for (const Door& door : plan_.doors) {
    if (!door.device || !plan_.settings.listeners[door.listener].bus) {
      continue;
    }
    Manners manners;
    manners.listener = door.listener;
    Client& client = clients_.emplace_back(manners, tools_);
    client.connect();
    bool well = false;
    for (int tries = 0; tries < kTries && !well; ++tries) {
      const std::uint64_t id = client.write(asking_.fresh_read(door));
      run_until(schedule_.now() + 500ms);
      well = oracle_.was_answered_well(id);
    }
    if (!well) {
      oracle_.violation("not_back", plan_.settings.devices[*door.device].name);
    }
  }
}

// What the gateway's own unit says of each bus must be what was seen here.
void World::check_counters() {
  Client& client = clients_.emplace_back(Manners{}, tools_);
  client.connect();
  const auto long_at = [&](std::size_t place) {
    const PduBytes& pdu = oracle_.own_answer();
    return pdu.size() < 2 + 2 * place + 4
               ? std::uint64_t{0}
               : (std::uint64_t{modbus::load_be16(pdu, 2 + 2 * place)} << 16U) |
                     modbus::load_be16(pdu, 4 + 2 * place);
  };
  for (std::size_t bus = 0; bus < buses_.size(); ++bus) {
    constexpr std::size_t kTransmissions = 2;
    constexpr std::size_t kLosses = 24;
    constexpr std::size_t kBroadcasts = 28;
    client.write(Asking::own_read(static_cast<std::uint16_t>(1000 + 64 * bus), 64));
    run_until(schedule_.now() + 10ms);
    const auto& count = oracle_.count(bus);
    const auto compare = [&](const char* what, std::size_t place, std::uint64_t seen) {
      if (long_at(place) != seen) {
        oracle_.violation("counter", plan_.settings.buses[bus].name + ": " + what + " " +
                                         std::to_string(long_at(place)) + ", seen " +
                                         std::to_string(seen));
      }
    };
    compare("transmissions", kTransmissions, count.transmissions);
    compare("losses", kLosses, count.losses);
    compare("broadcasts", kBroadcasts, count.broadcasts);
  }
}

}  // namespace mbgate::soak
