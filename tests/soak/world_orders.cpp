// SPDX-License-Identifier: Apache-2.0
// What the process itself says to the gateway: that it has not run, and that counters begin anew.
#include "soak/world.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

namespace {

constexpr std::uint64_t kClearsChance = 0x434C454152ULL;

}  // namespace

// As the process does it: first the gateway knows, then each socket is looked at.
void World::stalled(Duration missed) {
  report_.fault("driver_notices_stop");
  const auto lasted = std::chrono::floor<std::chrono::milliseconds>(missed);
  oracle_.stalled(schedule_.now() - lasted);
  harness_.handle(gateway::Stalled{lasted}, schedule_.now());
  drain();
  for (Client& client : clients_) {
    client.be_read();
  }
}

// What was counted is forgotten, and nothing else.
void World::clear_counters_some_time() {
  constexpr unsigned kSome = 100;
  Random random(plan_.seed ^ kClearsChance);
  if (!random.chance(kSome)) {
    return;
  }
  schedule_.after(random.duration(100ms, 5s), [this] {
    driver_.post([this] {
      report_.fault("counters_cleared");
      counters_cleared_ = true;
      harness_.handle(gateway::ClearCountersAsked{}, schedule_.now());
      drain();
    });
  });
}

}  // namespace mbgate::soak
