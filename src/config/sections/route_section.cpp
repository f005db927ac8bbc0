// SPDX-License-Identifier: Apache-2.0
// Where a route begins and where it leads; what it lets through is in route_rules.cpp.
#include <array>
#include <string>
#include <utility>

#include "config/sections/sections.hpp"
#include "config/toml/toml_value.hpp"

namespace mbgate::config {
namespace {

using routing::BroadcastReply;
using routing::Route;

constexpr std::array kBroadcastTargets = {Word{"all", true}};

void read_listener(Draft& draft, TomlTable& table, Route& route) {
  const auto listener = find_named(table, "listener", draft.settings.listeners);
  if (!listener) {
    return;
  }
  route.listener = routing::ListenerId{static_cast<std::uint32_t>(*listener)};
  if (draft.settings.listeners[*listener].bus) {
    table.error("listener", in_quotes(draft.settings.listeners[*listener].name) +
                                " is transparent (it has 'bus'): it takes no routes");
  }
}

std::optional<UnitRange> read_unit(const Draft& draft, TomlTable& table, Route& route) {
  table.require("unit");
  const auto units = read_units(table, "unit", kUnits);
  if (!units) {
    return std::nullopt;
  }
  route.first_unit = units->first;
  route.last_unit = units->last;
  const auto own = draft.settings.status_unit;
  if (own && units->contains(*own)) {
    table.error("unit", "{} is the gateway itself ([gateway] unit)", *own);
  }
  if (units->first == 0 && units->last != 0) {
    table.error("unit", "0 is for broadcasts: it stands alone, in a route of its own");
    return std::nullopt;
  }
  return units;
}

void read_device(Draft& draft, TomlTable& table, const UnitRange& units, Route& route) {
  if (table.has("address")) {
    table.error("address", "belongs to a route with 'bus'; a device has its own address");
  }
  if (units.size() != 1) {
    table.error("unit", "a route to a device has one unit, found a range of {}", units.size());
  }
  if (const auto found = find_named(table, "device", draft.settings.devices)) {
    const auto& device = draft.settings.devices[*found];
    route.buses = {device.bus};
    route.first_address = device.address;
    route.device = found;
  }
}

void read_bus(Draft& draft, TomlTable& table, const UnitRange& units, Route& route) {
  bool tcp = false;
  if (const auto bus = find_named(table, "bus", draft.settings.buses)) {
    route.buses = {drive::BusId{static_cast<std::uint32_t>(*bus)}};
    tcp = is_tcp(draft, route.buses.front());
  }
  if (!table.has("address")) {
    if (!tcp && units.last > kSerialAddresses.max) {
      table.error("unit", "no bus has an address {} (1 to 247): give 'address'", units.last);
    }
    route.first_address = units.first;
    return;
  }
  const auto addresses = read_units(table, "address", tcp ? kUnits : kSerialAddresses);
  if (!addresses) {
    return;
  }
  route.first_address = addresses->first;
  if (addresses->size() != units.size()) {
    table.error("address", "expected as many addresses as units ({}), found {}", units.size(),
                addresses->size());
  }
}

void read_unicast_target(Draft& draft, TomlTable& table, const UnitRange& units, Route& route) {
  const bool to_device = table.has("device");
  table.reject({"broadcast", "broadcast_mixed", "broadcast_reply"},
               units.first == 0 ? "a route with 'device' is not a broadcast"
                                : "belongs to a route with unit = 0");
  const bool to_bus = table.has("bus");
  if (to_device && to_bus) {
    table.error("bus", "a route leads to a device or to a bus, not to both");
  } else if (to_device) {
    read_device(draft, table, units, route);
  } else if (to_bus) {
    read_bus(draft, table, units, route);
  } else {
    draft.document.error(table.position(),
                         "[[route]]: has no target: expected 'device', or 'bus' and 'address'");
  }
}

/// Every serial line; a Modbus TCP server has no broadcasts.
std::vector<drive::BusId> serial_buses(const Draft& draft) {
  std::vector<drive::BusId> buses;
  for (std::size_t i = 0; i < draft.settings.buses.size(); ++i) {
    const drive::BusId id{static_cast<std::uint32_t>(i)};
    if (!is_tcp(draft, id)) {
      buses.push_back(id);
    }
  }
  return buses;
}

void read_broadcast_buses(Draft& draft, TomlTable& table, Route& route) {
  const auto bus = find_named(table, "bus", draft.settings.buses);
  const auto all = table.word<bool>("broadcast", kBroadcastTargets);
  if (table.has("bus") && table.has("broadcast")) {
    table.error("broadcast", "a broadcast goes to one bus or to all, not to both");
  } else if (bus) {
    route.buses = {drive::BusId{static_cast<std::uint32_t>(*bus)}};
    if (is_tcp(draft, route.buses.front())) {
      table.error("bus", in_quotes(draft.settings.buses[*bus].name) +
                             " is a Modbus TCP server, which gets no broadcasts");
    }
  } else if (all) {
    route.buses = serial_buses(draft);
    if (route.buses.empty() && !draft.settings.buses.empty()) {
      table.error("broadcast", "every [[bus]] is a Modbus TCP server: there are no broadcasts");
    }
  } else if (!table.has("bus") && !table.has("broadcast")) {
    draft.document.error(table.position(),
                         "[[route]]: has no target: expected 'bus' or broadcast = \"all\", or "
                         "'device' if unit 0 is not a broadcast");
  }
}

void read_broadcast_target(Draft& draft, TomlTable& table, Route& route) {
  if (table.has("address")) {
    table.error("address",
                "a broadcast (unit 0) is for a whole bus: expected 'bus' or broadcast = \"all\"; a "
                "route with 'device' is not a broadcast");
  }
  assign(route.broadcast_reply, table.word<BroadcastReply>("broadcast_reply", kBroadcastReplies));
  read_broadcast_buses(draft, table, route);
  assign(route.broadcast_mixed, table.boolean("broadcast_mixed"));
  if (!route.broadcast_mixed) {
    check_broadcast_mixed(draft, table, table.has("bus") ? "bus" : "broadcast", route.buses);
  }
}

using gateway::DeviceGuard;
using gateway::WriterRule;

void read_writer(Draft& draft, TomlTable& table, DeviceGuard& guard) {
  constexpr std::array kRules = {Word{"any", WriterRule::any}, Word{"first", WriterRule::first}};
  const auto* found = table.value("writer");
  if (found == nullptr) {
    return;
  }
  const auto* text = std::get_if<std::string>(&found->data);
  const auto rule = text != nullptr ? value_of(kRules, *text) : std::nullopt;
  if (rule) {
    guard.writer = *rule;
  } else if (is_empty_list(*found)) {
    table.error("writer",
                "expected at least one address; access = \"read-only\" on the routes lets "
                "nobody write");
  } else if (std::holds_alternative<std::vector<TomlValue>>(found->data)) {
    guard.writer = WriterRule::listed;
    guard.writers = read_clients(draft, table, "writer");
  } else {
    table.report_expected("writer", *found,
                          R"("any", "first", or a list of addresses such as ["192.168.10.5"])");
  }
}

void check_hold(TomlTable& table, const DeviceGuard& guard) {
  if (table.has("writer_hold") && guard.writer != WriterRule::first) {
    table.warning("writer_hold", "does nothing without writer = \"first\"");
  }
}

void check_occasions(TomlTable& table, const DeviceGuard& guard) {
  constexpr std::array kNeedWrites = {
      std::pair("failsafe_clients", "when these clients have gone"),
      std::pair("failsafe_grace", "when a client has gone for this time"),
      std::pair("quiet", "after this silence"),
      std::pair("failsafe_on_exit", "when the gateway stops")};
  const auto* writes = table.value("failsafe");
  const bool has_writes = writes != nullptr && !is_empty_list(*writes);
  for (const auto& [key, occasion] : kNeedWrites) {
    if (table.has(key) && !has_writes) {
      table.error(key, "needs 'failsafe', the writes to send {}", occasion);
    }
  }
  if (has_writes && guard.quiet > gateway::Duration{0} && guard.quiet < guard.failsafe_grace) {
    table.warning("quiet", "failsafe_grace, {}, is longer, and has to pass too",
                  to_text(guard.failsafe_grace));
  }
}

}  // namespace

void read_routes(Draft& draft) {
  for (auto table : draft.document.root().tables("route")) {
    Route route;
    read_listener(draft, table, route);
    const auto units = read_unit(draft, table, route);
    // Without a usable unit nobody can say which of these are right; none of them is unknown.
    table.accept({"device", "bus", "address", "broadcast", "broadcast_mixed", "broadcast_reply"});
    const bool broadcast = units && units->first == 0 && !table.has("device");
    if (broadcast) {
      read_broadcast_target(draft, table, route);
    } else if (units) {
      read_unicast_target(draft, table, *units, route);
    }
    read_route_rules(draft, table, route, broadcast);
    draft.routes.push_back(table);
    draft.route_units.push_back(units);
    draft.settings.routes.push_back(std::move(route));
  }
}

gateway::DeviceGuard read_guard(Draft& draft, TomlTable& table, const drive::Device& device) {
  DeviceGuard guard;
  read_keys(table, guard_keys(), guard);
  read_writer(draft, table, guard);
  check_hold(table, guard);
  guard.failsafe_clients = read_clients(draft, table, "failsafe_clients");
  guard.failsafe = read_failsafe(table, device);
  check_occasions(table, guard);
  return guard;
}

}  // namespace mbgate::config
