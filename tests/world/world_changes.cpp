// SPDX-License-Identifier: Apache-2.0
// What is done to the process: it is killed and started again while answers are on their way, and
// gets other settings.
#include <algorithm>

#include "world/rights.hpp"
#include "world/world.hpp"

namespace mbgate::world {
namespace {

// Some names in turn: so some come back, and the gateway, which keeps a number for each that it has
// ever read, does not have thousands.
void rename(std::string& name) {
  constexpr std::string_view kMost = "xxxx";
  if (name.ends_with(kMost)) {
    name.resize(name.size() - kMost.size());
  } else {
    name += "x";
  }
}

}  // namespace

void World::number_buses() {
  const gateway::Settings& in_force = harness_->settings();
  for (std::size_t bus = 0; bus < buses_.size(); ++bus) {
    for (std::uint32_t id = 0; id < in_force.buses.size(); ++id) {
      if (!in_force.buses[id].is_gone && in_force.buses[id].name == plan_.bus(bus).name) {
        buses_[bus].id = id;
      }
    }
  }
}

void World::again(Duration every, void (World::*event)()) {
  if (every > Duration{0}) {
    schedule_.after(changes_.duration(every / 4, 2 * every), [this, every, event] {
      if (!ledger_.calm && ledger_.stopping == kNever) {
        again(every, event);
        (this->*event)();
      }
    });
  }
}

// What is on its way comes all the same, and nobody tells the new process anything.
void World::restart() {
  if (draining_ || driver_.is_awake()) {
    return;
  }
  driver_.come_back();
  report_.fault("process_restarted");
  trace("killed, and started again");
  ++ledger_.process;
  ledger_.started = schedule_.now();
  for (Client& client : clients_) {
    client.be_cut_off();
  }
  for (std::size_t bus = 0; bus < buses_.size(); ++bus) {
    close_line(bus);
    buses_[bus].unsent = 0;
  }
  harness_.emplace(plan_.settings, schedule_.now());
  number_buses();
  drain();
}

void World::reload() {
  driver_.post([this] {
    if (ledger_.calm || ledger_.stopping != kNever) {
      return;
    }
    driver_.come_back();
    report_.fault("reload");
    change_settings();
    if (plan_.meanings_change) {
      change_meaning();
    }
    take_rights();
    set_deadlines(plan_);
    change(plan_.settings);
  });
}

// A bus whose number changes is another one with the same line.
void World::hand_in_settings(const gateway::Settings& settings) {
  witness_->reloaded();
  harness_->handle(gateway::SettingsChanged{&settings}, schedule_.now());
  std::vector<std::uint32_t> before;
  std::ranges::transform(buses_, std::back_inserter(before),
                         [](const BusState& it) { return it.id; });
  number_buses();
  for (std::size_t bus = 0; bus < buses_.size(); ++bus) {
    if (buses_[bus].id != before[bus]) {
      report_.fault("bus_renamed");
      close_line(bus);
    }
  }
  drain();
}

void World::change(const gateway::Settings& settings) {
  ledger_.reloaded = schedule_.now();
  trace("reload");
  hand_in_settings(settings);
}

// Who has written to them before is still who has written to them.
void World::rename_devices() {
  report_.fault("devices_renamed");
  for (drive::Device& device : plan_.settings.devices) {
    device.name += "y";
  }
  driver_.post([this] { hand_in_settings(plan_.settings); });
}

// Nothing of what was asked means anything else by these.
void World::change_settings() {
  gateway::Settings& settings = plan_.settings;
  const std::size_t device = changes_.below(settings.devices.size());
  const std::size_t bus = changes_.below(settings.buses.size());
  if (changes_.chance(400)) {
    const Duration slow = settings.devices[device].profile.slow.front().response_timeout;
    draw_timing(settings.devices[device].timing, plan_.default_times, changes_);
    settings.devices[device].profile.slow.front().response_timeout = slow;
  }
  if (changes_.chance(100)) {
    rename(settings.devices[device].name);
  }
  if (changes_.chance(60)) {
    rename(settings.buses[bus].name);
  }
  if (changes_.chance(60) && !settings.buses[bus].line.remote) {
    report_.fault("low_latency_changed");
    settings.buses[bus].line.low_latency = !settings.buses[bus].line.low_latency;
  }
  if (changes_.chance(200)) {
    settings.buses[bus].coalesce = !settings.buses[bus].coalesce;
    settings.buses[bus].burst = changes_.between(1U, 8U);
  }
  if (changes_.chance(200)) {
    auto& listener = settings.listeners[changes_.below(settings.listeners.size())];
    listener.pipeline = changes_.one_of<std::size_t>({1, 4, 16, 64});
  }
}

// What a client has asked before may mean something else now: it is refused, or was not read yet.
void World::change_meaning() {
  const std::size_t at = changes_.below(plan_.settings.routes.size());
  routing::Route& route = plan_.settings.routes[at];
  if (!route.device || !changes_.chance(500)) {
    return;
  }
  report_.fault("order_changed");
  const drive::Device& device = plan_.settings.devices[*route.device];
  route.word_order = changes_.one_of({drive::WordOrder::big, drive::WordOrder::little});
  for (std::size_t place = 0; place < plan_.doors.size(); ++place) {
    Door& door = plan_.doors[place];
    if (door.route != at) {
      continue;
    }
    const bool before = door.swapped;
    door.swapped = *route.word_order != *device.word_order;
    if (before != door.swapped) {
      outdate(place);
    }
  }
}

// What waits for a right that is gone may not go any more.
void World::take_rights() {
  if (plan_.takes_rights == 0 || !rights_.chance(300)) {
    return;
  }
  --plan_.takes_rights;
  report_.fault(take_right(plan_, rights_));
  for (Asked& asked : ledger_.asked) {
    const bool is_open = asked.answers == 0 && !asked.dropped && asked.intent.kind != Kind::own;
    if (!is_open || !asked.sent.empty()) {
      continue;
    }
    if (asked.intent.refused) {
      asked.intent.codes |= code(1);
      continue;
    }
    Intent again = asked.intent;
    const Connection& connection = ledger_.connections[asked.connection];
    asking_.check_rights(again, connection.listener, connection.host);
    if (again.refused) {
      report_.fault("right_taken");
      asked.withdrawn = true;
      asked.intent.codes |= code(1);
    }
  }
}

// What was given to the gateway, and waits there alone, it has understood already.
void World::outdate(std::size_t door) {
  std::unordered_map<Id, unsigned> open;
  for (const Asked& asked : ledger_.asked) {
    open[asked.connection] += asked.answers == 0 && !asked.dropped ? 1U : 0U;
  }
  for (Id id = 0; id < ledger_.asked.size(); ++id) {
    Asked& asked = ledger_.asked[id];
    const bool is_open = asked.answers == 0 && !asked.dropped;
    if (!is_open || asked.intent.kind == Kind::own || asked.intent.door != door) {
      continue;
    }
    const bool is_understood = asked.given != kNever && open[asked.connection] == 1;
    (is_understood ? asked.outdated : asked.perhaps_outdated) = true;
    for (const Cell& cell : asked.intent.writes) {
      const bool is_masks = cell.place >= kMasks && cell.place < kOpaque;
      const unsigned shift = is_masks ? kMasks : 0;
      if (cell.table == Table::holding_registers && cell.place < kOpaque) {
        const Cell other{cell.table, partner_of(cell.place - shift) + shift, cell.word};
        ledger_.writer.try_emplace(key_of(*asked.intent.station, other), id);
      }
    }
  }
}

}  // namespace mbgate::world
