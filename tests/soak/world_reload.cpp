// SPDX-License-Identifier: Apache-2.0
// Other settings while everything runs.
#include <algorithm>

#include "soak/world.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

void World::begin_reloads() {
  if (const auto pause = reloads_.pause()) {
    schedule_.after(*pause, [this] {
      driver_.post([this] {
        if (plan_.calm.left(schedule_.now()) > Duration{0}) {
          begin_reloads();
        } else if (trouble_ && !is_stopping_) {
          const std::vector<bool> before = plan_.absent.buses;
          oracle_.before_reload();
          reload(reloads_.draw(), before);
          begin_reloads();
        }
      });
    });
  }
}

void World::restore() {
  if (!reloads_.are_any() && !plan_.limits_hosts) {
    return;
  }
  const std::vector<bool> before = plan_.absent.buses;
  oracle_.before_reload();
  reload(reloads_.restore(), before);
  run_until(schedule_.now() + 5s);
}

void World::reload(const Reload& reload, const std::vector<bool>& absent) {
  report_.fault(reload.is_order_only() ? "reload_order" : "reload");
  for (const char* kind : reload.kinds) {
    report_.fault(kind);
    trace(kind);
  }
  driver_.come_back();
  take_effect(reload, absent);
  order_only_ = reload.is_order_only();
  const gateway::Settings settings = reloads_.take_settings();
  harness_.handle(gateway::SettingsChanged{&settings}, schedule_.now());
  drain();
  order_only_ = false;
  oracle_.check_taken_back();
  for (const std::size_t bus : std::exchange(shut_due_, {})) {
    oracle_.violation("not_shut", plan_.settings.buses[bus].name);
  }
  for (const ClientId client : std::exchange(close_due_, {})) {
    oracle_.violation("not_closed", std::to_string(static_cast<std::uint64_t>(client)));
  }
}

void World::take_effect(const Reload& reload, const std::vector<bool>& absent) {
  for (Client& client : clients_) {
    if (client.is_connected() && !client.is_welcome()) {
      close_due_.insert(client.number());
      client.give_up();
    }
  }
  for (const std::size_t listener : reload.idle) {
    plan_.idle_from[listener] = schedule_.now();
  }
  std::ranges::for_each(reload.touched, [&](std::size_t bus) { oracle_.touched(bus); });
  for (const auto& [bus, address] : reload.changed) {
    oracle_.take_back(bus, address);
  }
  for (const std::size_t bus : reload.lines) {
    buses_[bus].open = false;
    ++buses_[bus].epoch;
    driver_.forget_line(bus);
    std::visit([](auto& wire) { wire.reset(false); }, wires_[bus]);
    oracle_.line_given_up(bus);
    hangs_.forget(bus);
    if (!absent[bus]) {
      shut_due_.insert(bus);
    }
  }
  oracle_.after_reload();
}

// The same things in another order: nobody notices. What was due anyhow may happen now.
void World::check_order_only(const gateway::Action& action) {
  const bool gives_up = std::holds_alternative<gateway::Open>(action) ||
                        std::holds_alternative<gateway::Shut>(action) ||
                        std::holds_alternative<gateway::Close>(action);
  if (const auto* shut = std::get_if<gateway::Shut>(&action)) {
    const auto bus = static_cast<std::size_t>(shut->bus);
    // The line hangs, or what a look at it has brought cannot be followed.
    order_only_ = order_only_ && !hangs_.is_due(bus, schedule_.now()) && !buses_[bus].framing_lost;
  }
  const auto* open = std::get_if<gateway::Open>(&action);
  const auto* close = std::get_if<gateway::Close>(&action);
  const Client* client = close == nullptr ? nullptr : find(close->client);
  const bool is_due =
      (open != nullptr && oracle_.may_be_wanted(static_cast<std::size_t>(open->bus))) ||
      (client != nullptr && client->may_be_found_lost());
  if (order_only_ && gives_up && !is_due) {
    oracle_.violation("reload_disturbs", gateway::to_text(action, harness_.settings()));
  }
}

}  // namespace mbgate::soak
