// SPDX-License-Identifier: Apache-2.0
// Deadlines of routes against the times of the devices that they reach.
#include <algorithm>

#include "config/sections/sections.hpp"
#include "config/toml/duration_text.hpp"
#include "gateway/limits.hpp"

namespace mbgate::config {
namespace {

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
        "deadline", to_text(*route.deadline) + " is shorter than " + to_text(sensible) +
                        " (500ms, and twice the longest transaction of the bus): "
                        "requests may give up behind one silent device or one lost answer");
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
    return "a write is repeated " + to_text(after) +
           " after it was sent (response timeout and quarantine), and its deadline is " +
           to_text(deadline) + " after it came";
  };
  const auto standard = default_deadline(settings, device.bus);
  const bool by_listener = is_reached_by_listener(settings, device);
  if (standard <= after && (by_listener || is_reached_by_default(settings, device))) {
    // What a listener leads to is not helped by routes.
    const auto other =
        by_listener ? "" : ", or give its routes a deadline of more than " + to_text(after);
    draft.devices[at].error("retry_writes", "does nothing: " + explain(standard) +
                                                "; make the quarantine shorter" + other);
  }
  for (std::size_t i = 0; i < draft.routes.size(); ++i) {
    const auto& route = settings.routes[i];
    if (route.deadline && *route.deadline <= after && writes_reach(route, device)) {
      draft.routes[i].error("deadline", "makes retry_writes of " + in_quotes(device.name) +
                                            " do nothing: " + explain(*route.deadline) +
                                            "; make it more than " + to_text(after));
    }
  }
}

}  // namespace

void check_deadlines(Draft& draft) {
  for (std::size_t at = 0; at < draft.routes.size(); ++at) {
    check_length(draft, at);
  }
  for (std::size_t at = 0; at < draft.devices.size(); ++at) {
    check_repeated_writes(draft, at);
  }
}

}  // namespace mbgate::config
