// SPDX-License-Identifier: Apache-2.0
// What only the whole configuration shows.
#include <algorithm>
#include <fmt/core.h>

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

/// Transparent listeners pass units 1 to 247 and those of devices, but for 255, which is the
/// gateway; and broadcasts if they are told to.
bool passes_writes(const gateway::ListenerSettings& listener, const drive::Device& device) {
  constexpr std::uint8_t kLastUnit = 254;
  return listener.bus == device.bus && (listener.broadcast || device.has_every_unit ||
                                        (device.address >= 1 && device.address <= kLastUnit));
}

/// Does the configuration say whose leaving sends the failsafe writes?
bool is_said_who_counts(const gateway::DeviceGuard& guard) {
  return !guard.failsafe_clients.empty() ||
         (guard.writer == gateway::WriterRule::listed && guard.writers.names_one());
}

/// Failsafe writes are sent when the client that counts has gone.
void check_failsafe(Draft& draft) {
  const auto& settings = draft.settings;
  for (std::size_t i = 0; i < settings.devices.size(); ++i) {
    const auto& device = settings.devices[i];
    const bool written =
        std::ranges::any_of(settings.listeners,
                            [&](const auto& it) { return passes_writes(it, device); }) ||
        std::ranges::any_of(settings.routes, [&](const Route& route) {
          return route.may_write() && route.leads_to(device);
        });
    if (settings.guards[i].failsafe.empty()) {
      continue;
    }
    if (written && !is_said_who_counts(settings.guards[i])) {
      draft.devices[i].warning(
          "failsafe",
          "the client that wrote last counts, and more than one may write: name in "
          "failsafe_clients the clients whose disconnection sends these writes");
    }
    if (!written) {
      draft.devices[i].warning("failsafe",
                               "is never sent: no listener and no route lets a client write to "
                               "this device");
    }
  }
}

/// A client whose place is needed for another one is gone, and that sends the failsafe writes.
void check_room(Draft& draft) {
  const auto& settings = draft.settings;
  bool any_kept = false;
  for (std::size_t i = 0; i < settings.listeners.size(); ++i) {
    const auto& listener = settings.listeners[i];
    any_kept = any_kept || !listener.keep.empty();
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

void check_ways(Draft& draft) {
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
    const bool served = std::ranges::any_of(settings.routes, [&](const Route& route) {
      return !route.listener || index(*route.listener) == i;
    });
    any_routed = any_routed || routed;
    if (routed && !served) {
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
using gateway::Settings;
using routing::Route;

Duration default_deadline(const Settings& settings, drive::BusId id) {
  return gateway::write_deadline(
      bus::longest_transaction(settings.bus(id), settings.devices_on(id)));
}

Duration sensible_deadline(const Settings& settings, const Route& route) {
  Duration sensible{0};
  for (const auto id : route.buses) {
    if (index(id) < settings.buses.size()) {
      sensible = std::max(sensible, default_deadline(settings, id));
    }
  }
  return sensible;
}

void check_length(Draft& draft, std::size_t at) {
  const auto& route = draft.settings.routes[at];
  const auto sensible = sensible_deadline(draft.settings, route);
  if (route.deadline && *route.deadline < sensible) {
    draft.routes[at].warning(
        "deadline",
        "{} is shorter than {} (500ms, and twice the longest transaction of the bus): one silent "
        "device or one lost answer can use up this deadline",
        to_text(*route.deadline), to_text(sensible));
  }
}

/// How long after its first transmission a write is repeated, silence and all: its device is left
/// alone until the late answer to the first one cannot come any more.
Duration repeated_after(const Draft& draft, const drive::Device& device) {
  const auto& timing = device.timing;
  Duration longest = timing.response_timeout;
  for (const auto& slow : device.profile.slow) {
    longest = std::max(longest, slow.response_timeout);
  }
  const auto quarantine = is_tcp(draft, device.bus) ? Duration{0} : timing.quarantine_or_default();
  return longest + timing.response_wait + quarantine;
}

bool writes_reach(const Route& route, const drive::Device& device) {
  // A route to a device that nobody knows has no bus.
  return !route.buses.empty() && route.may_write() && route.leads_to(device);
}

/// Transparent listeners have no deadline of their own.
bool is_reached_by_listener(const Settings& settings, const drive::Device& device) {
  return std::ranges::any_of(settings.listeners,
                             [&](const auto& listener) { return listener.bus == device.bus; });
}

/// Is there a route for writes to it that states no deadline?
bool is_reached_by_default(const Settings& settings, const drive::Device& device) {
  return std::ranges::any_of(settings.routes, [&](const Route& route) {
    return !route.deadline && writes_reach(route, device);
  });
}

/// `retry_writes` that can do nothing, because the deadline ends before a write may be repeated.
void check_repeated_writes(Draft& draft, std::size_t at) {
  const auto& settings = draft.settings;
  const auto& device = settings.devices[at];
  if (!device.timing.retry_writes || index(device.bus) >= settings.buses.size()) {
    return;
  }
  if (device.timing.retries == 0) {
    draft.devices[at].error("retry_writes", "does nothing with retries = 0");
    return;
  }
  const auto after = repeated_after(draft, device);
  const auto explain = [&](Duration deadline) {
    return fmt::format(
        "a write is repeated {} after it was sent (response timeout and quarantine), and its "
        "deadline is {} after it came",
        to_text(after), to_text(deadline));
  };
  const auto standard = default_deadline(settings, device.bus);
  const bool by_listener = is_reached_by_listener(settings, device);
  if (standard <= after && (by_listener || is_reached_by_default(settings, device))) {
    // What a listener leads to is not helped by routes.
    const auto other =
        by_listener ? "" : ", or give its routes a deadline of more than " + to_text(after);
    draft.devices[at].error("retry_writes", "does nothing: {}; make the quarantine shorter{}",
                            explain(standard), other);
  }
  for (std::size_t i = 0; i < draft.routes.size(); ++i) {
    const auto& route = settings.routes[i];
    if (route.deadline && *route.deadline <= after && writes_reach(route, device)) {
      draft.routes[i].error("deadline",
                            "makes retry_writes of {} do nothing: {}; make it more than {}",
                            in_quotes(device.name), explain(*route.deadline), to_text(after));
    }
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
    check_ways(draft);
    check_failsafe(draft);
    check_room(draft);
    check_rules(draft);
  }
}

void check_deadlines(Draft& draft) {
  for (std::size_t at = 0; at < draft.routes.size(); ++at) {
    check_length(draft, at);
  }
  for (std::size_t at = 0; at < draft.devices.size(); ++at) {
    check_repeated_writes(draft, at);
  }
}

}  // namespace mbgate::config
