// SPDX-License-Identifier: Apache-2.0
// The process is killed, and started again on the same lines: what is on its way comes all the
// same. Nobody tells the new one anything but the settings.
#include <algorithm>
#include <memory>

#include "soak/world.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

void World::begin_restarts() {
  const Duration every = plan_.restarts_every;
  if (every == Duration{0}) {
    return;
  }
  schedule_.after(restarts_.duration(every / 4, 2 * every), [this] {
    restart();
    begin_restarts();
  });
}

// Things are numbered by their places in the settings: all of them must be there.
void World::restart() {
  const auto is_whole = [](const std::vector<bool>& absent) {
    return std::ranges::count(absent, true) == 0;
  };
  const Absent& absent = plan_.absent;
  if (!trouble_ || is_stopping_ || stuck_ || draining_ || driver_.is_awake() ||
      plan_.calm.left(schedule_.now()) > Duration{0} || !is_whole(absent.listeners) ||
      !is_whole(absent.buses) || !is_whole(absent.devices) || !is_whole(absent.routes)) {
    return;
  }
  driver_.come_back();
  report_.fault("process_restarted");
  trace("killed, and started again");
  for (Client& client : clients_) {
    client.be_cut_off();
  }
  for (std::size_t bus = 0; bus < buses_.size(); ++bus) {
    ++buses_[bus].epoch;
    buses_[bus].open = buses_[bus].framing_lost = false;
    driver_.forget_line(bus);
    std::visit([](auto& wire) { wire.reset(false); }, wires_[bus]);
    hangs_.forget(bus);
  }
  frames_.clear();
  Past past = oracle_.take_past();
  std::destroy_at(&oracle_);
  std::construct_at(&oracle_, plan_, devices_, schedule_, report_);
  oracle_.begin_with(std::move(past));
  if (trace_) {
    oracle_.trace();
  }
  std::destroy_at(&harness_);
  std::construct_at(&harness_, reloads_.settings_in_order(), schedule_.now());
  drain();
}

}  // namespace mbgate::soak
