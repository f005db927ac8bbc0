// SPDX-License-Identifier: Apache-2.0
// What only the whole configuration shows.
#include <algorithm>
#include <ranges>
#include <span>

#include "config/sections/sections.hpp"
#include "config/toml/toml_value.hpp"
#include "gateway/limits.hpp"

namespace mbgate::config {
namespace {

using gateway::Settings;
using routing::Route;

/// Warnings, because a gateway that is not configured yet can be asked for its status and reloaded.
void check_present(Draft& draft) {
  if (stands_nowhere(draft.document.root(), "bus")) {
    draft.document.warning({},
                           "no [[bus]] is configured: no device can be reached; a reload that "
                           "removes all buses is refused");
  }
  if (stands_nowhere(draft.document.root(), "listen")) {
    draft.document.warning({}, "no [[listen]] is configured: no client can connect");
  }
}

/// A unit leads to one place only; the later route of two is reported. A route that names its
/// listener goes before one that names none, so these two do not clash.
void check_overlaps(Draft& draft) {
  const auto& routes = draft.settings.routes;
  for (std::size_t later = 0; later < routes.size(); ++later) {
    const auto& units = draft.route_units[later];
    for (std::size_t earlier = 0; units && earlier < later; ++earlier) {
      const auto& taken = draft.route_units[earlier];
      if (!taken || !units->overlaps(*taken) ||
          routes[later].listener != routes[earlier].listener) {
        continue;
      }
      draft.routes[later].error("unit", "{} already has a route at {}",
                                std::max(units->first, taken->first),
                                draft.routes[earlier].place_of("unit"));
      break;
    }
  }
}

bool is_reached(const Settings& settings, drive::BusId id) {
  return std::ranges::any_of(settings.listeners, [&](const auto& it) { return it.bus == id; }) ||
         std::ranges::any_of(settings.routes, [&](const Route& route) {
           return std::ranges::find(route.buses, id) != route.buses.end();
         });
}

routing::RouteTable table_of(const Settings& settings) {
  std::vector<routing::ListenerKind> kinds;
  for (const auto& listener : settings.listeners) {
    kinds.push_back({.bus = listener.bus, .broadcast = listener.broadcast});
  }
  return {kinds, settings.routes, settings.devices};
}

/// The listeners that let clients write to the device.
std::vector<gateway::ListenerSettings> writing_listeners(const Settings& settings,
                                                         const routing::RouteTable& table,
                                                         const drive::Device& device) {
  std::vector<gateway::ListenerSettings> listeners;
  for (std::size_t at = 0; at < settings.listeners.size(); ++at) {
    const auto leads = [&](std::size_t unit) {
      const auto* found = table.find(routing::ListenerId(at), static_cast<std::uint8_t>(unit));
      return found != nullptr && settings.status_unit != unit && found->route.may_write() &&
             found->leads_to(device, static_cast<std::uint8_t>(unit));
    };
    if (std::ranges::any_of(std::views::iota(std::size_t{0}, routing::UnitSet().size()), leads)) {
      listeners.push_back(settings.listeners[at]);
    }
  }
  return listeners;
}

bool let_in_one(std::span<const gateway::ListenerSettings> listeners) {
  return std::ranges::all_of(listeners, [&](const auto& it) {
    return it.allow.size() == 1 && it.allow.front().is_host() && !it.counts_certificates &&
           it.allow == listeners.front().allow;
  });
}

/// Does the configuration say whose leaving sends the failsafe writes?
bool is_said_who_counts(const gateway::DeviceGuard& guard) {
  return !guard.failsafe_clients.empty() ||
         (guard.writer == gateway::WriterRule::listed && guard.writers.names_one());
}

/// Of clients with certificates it is not known where they come from.
void check_let_in(TomlTable& table, std::string_view key, const routing::ClientList& clients,
                  std::span<const gateway::ListenerSettings> listeners) {
  if (clients.networks.empty() || !clients.roles.empty() || !clients.certificates.empty() ||
      listeners.empty()) {
    return;
  }
  for (const auto& [text, position] : table.strings(key).value_or(std::vector<TomlText>())) {
    const auto network = routing::Network::parse(text);
    if (std::ranges::none_of(listeners, [&](const auto& it) {
          return it.allow.empty() || routing::have_common(it.allow, {*network});
        })) {
      table.document().warning(position,
                               "{}: {} is never a client here: 'allow' does not let it in", key,
                               in_quotes(text));
    }
  }
}

/// Failsafe writes are sent when the client that counts has gone.
void check_guard(Draft& draft, const routing::RouteTable& routes, std::size_t at) {
  const auto& settings = draft.settings;
  const auto& guard = settings.guards[at];
  TomlTable& table = draft.devices[at];
  check_let_in(table, "writer", guard.writers, settings.listeners);
  check_let_in(table, "failsafe_clients", guard.failsafe_clients, settings.listeners);
  const auto listeners = writing_listeners(settings, routes, settings.devices[at]);
  if (guard.failsafe.empty()) {
    return;
  }
  if (listeners.empty()) {
    table.warning("failsafe",
                  "is never sent: no listener and no route lets a client write to this device");
  } else if (!is_said_who_counts(guard) && !let_in_one(listeners)) {
    table.warning("failsafe",
                  "the client that wrote last counts, and more than one may write: name in "
                  "failsafe_clients the clients whose disconnection sends these writes");
  }
}

/// A client whose place is needed for another one is gone, and that sends the failsafe writes.
void check_room(Draft& draft) {
  const auto& settings = draft.settings;
  bool any_kept = false;
  for (std::size_t i = 0; i < settings.listeners.size(); ++i) {
    const auto& listener = settings.listeners[i];
    any_kept = any_kept || !listener.keep.empty();
    check_let_in(draft.listeners[i], "keep", listener.keep, std::span(&listener, 1));
    if (listener.max_connections_per_address >= listener.max_connections) {
      TomlTable& table = draft.listeners[i];
      const bool is_stated = table.has("max_connections_per_address");
      table.warning(
          is_stated ? "max_connections_per_address" : "max_connections",
          "one client may take all {} connections: set max_connections_per_address ({}) below it",
          listener.max_connections, listener.max_connections_per_address);
    }
  }
  const auto& guards = settings.guards;
  const auto first =
      std::ranges::find_if(guards, [](const auto& it) { return !it.failsafe.empty(); });
  if (!any_kept && first != guards.end()) {
    draft.devices[static_cast<std::size_t>(first - guards.begin())].warning(
        "failsafe",
        "no listener has 'keep': name there the clients that drive such devices, so that none of "
        "them is closed to make room for others");
  }
}

void check_ways(Draft& draft, const routing::RouteTable& routes) {
  const auto& settings = draft.settings;
  for (std::size_t i = 0; i < settings.buses.size(); ++i) {
    if (!is_reached(settings, drive::BusId{static_cast<std::uint32_t>(i)})) {
      draft.document.warning(draft.buses[i].value_position("name"),
                             "no listener and no route leads to this bus");
    }
  }
  bool any_routed = false;
  for (std::size_t i = 0; i < settings.listeners.size(); ++i) {
    const bool routed = !settings.listeners[i].bus;
    any_routed = any_routed || routed;
    if (routed && routes.units(routing::ListenerId(i)).none()) {
      draft.document.warning(draft.listeners[i].value_position("name"),
                             "no route serves this listener and it has no 'bus'");
    }
  }
  if (!any_routed && !draft.routes.empty()) {
    draft.document.warning(draft.routes[0].position(),
                           "[[route]]: every listener has its 'bus', so no listener uses routes");
  }
}

using bus::Duration;

Duration default_deadline(const Settings& settings, drive::BusId id) {
  return gateway::write_deadline(
      bus::longest_transaction(settings.bus(id), settings.devices_on(id)));
}

void check_length(Draft& draft, TomlTable& table, std::string_view key, Duration given,
                  const std::vector<drive::BusId>& buses) {
  Duration sensible{0};
  for (const auto id : buses) {
    if (index(id) < draft.settings.buses.size()) {
      sensible = std::max(sensible, default_deadline(draft.settings, id));
    }
  }
  if (given < sensible) {
    table.warning(key,
                  "{} is shorter than {} (500ms, and twice the longest transaction of the bus): "
                  "one silent device or one lost answer can use it up",
                  to_text(given), rounded(sensible));
  }
}

/// The clients' own timeout is the deadline of all that they ask.
void check_give_up(Draft& draft, const routing::RouteTable& routes, std::size_t at) {
  const auto& listener = draft.settings.listeners[at];
  std::vector<drive::BusId> buses;
  for (std::size_t unit = 0; unit < routing::UnitSet().size(); ++unit) {
    if (const auto* found = routes.find(routing::ListenerId(at), static_cast<std::uint8_t>(unit))) {
      buses.insert(buses.end(), found->route.buses.begin(), found->route.buses.end());
    }
  }
  if (listener.give_up > Duration{0}) {
    check_length(draft, draft.listeners[at], "give_up", listener.give_up, buses);
  }
}

/// A write is repeated when the late answer to its first transmission cannot come any more.
void check_repeated_writes(Draft& draft, std::size_t at) {
  const auto& settings = draft.settings;
  const auto& device = settings.devices[at];
  const auto& timing = device.timing;
  if (!timing.retry_writes || index(device.bus) >= settings.buses.size()) {
    return;
  }
  if (timing.retries == 0) {
    draft.devices[at].error("retry_writes", "does nothing with retries = 0");
    return;
  }
  const bool is_held = !settings.bus(device.bus).has_identifiers();
  const auto after = timing.response_timeout + timing.response_wait +
                     (is_held ? timing.quarantine_or_default() : Duration{0});
  const auto deadline = default_deadline(settings, device.bus);
  const bool has_longer = std::ranges::any_of(settings.routes, [&](const Route& route) {
    return route.deadline && *route.deadline > after &&
           std::ranges::find(route.buses, device.bus) != route.buses.end();
  });
  if (after >= deadline && !has_longer) {
    draft.devices[at].warning(
        "retry_writes",
        "does nothing: a write is repeated {} after it was sent (response timeout and quarantine), "
        "and its deadline is {} after it came; make the quarantine shorter, or give its routes a "
        "longer deadline",
        to_text(after), rounded(deadline));
  }
}

void check_deadlines(Draft& draft) {
  for (std::size_t at = 0; at < draft.routes.size(); ++at) {
    const auto& route = draft.settings.routes[at];
    if (route.deadline) {
      check_length(draft, draft.routes[at], "deadline", *route.deadline, route.buses);
    }
  }
  for (std::size_t at = 0; at < draft.devices.size(); ++at) {
    check_repeated_writes(draft, at);
  }
}

}  // namespace

void check_whole(Draft& draft) {
  check_present(draft);
  check_overlaps(draft);
  check_routes(draft);
  check_deadlines(draft);
  // After an error a route may be missing only because the entry that leads there is wrong.
  if (!draft.document.failed()) {
    const auto routes = table_of(draft.settings);
    check_ways(draft, routes);
    for (std::size_t at = 0; at < draft.listeners.size(); ++at) {
      check_give_up(draft, routes, at);
    }
    for (std::size_t at = 0; at < draft.devices.size(); ++at) {
      check_guard(draft, routes, at);
    }
    check_room(draft);
    check_rules(draft, routes);
  }
}

}  // namespace mbgate::config
