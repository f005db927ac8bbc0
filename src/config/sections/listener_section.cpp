// SPDX-License-Identifier: Apache-2.0
#include <array>

#include "config/sections/sections.hpp"

namespace mbgate::config {
namespace {

using gateway::ListenerSettings;
using routing::BroadcastReply;
using routing::ClientAddress;

void read_address(TomlTable& table, ListenerSettings& listener) {
  if (const auto address = table.string("address")) {
    listener.address = *address;
    const auto parsed = ClientAddress::parse(*address);
    if (!parsed) {
      table.report_expected("address", *table.value("address"),
                            R"(an IPv4 or IPv6 address, such as "127.0.0.1" or "::")");
    } else if (routing::is_link_local(*parsed)) {
      table.error("address", kNoScope);
    }
  }
  if (!table.has("tls")) {
    table.require("port");
  }
  const std::int64_t otherwise = table.has("port") ? 0 : kSecurePort;
  listener.port = static_cast<std::uint16_t>(table.integer("port", {0, 65535}).value_or(otherwise));
}

void read_handshakes(Draft& draft, TomlTable& table, ListenerSettings& listener) {
  listener.tls = find_named(table, "tls", draft.settings.tls);
  if (!table.has("tls")) {
    table.reject(
        {"handshake_timeout", "hello_timeout", "max_handshakes", "max_handshakes_per_client",
         "max_handshakes_per_second", "max_handshakes_per_second_per_client"},
        "belongs to a listener with 'tls'");
  }
}

bool is_every_interface(const ClientAddress& address) {
  return address == ClientAddress::parse("0.0.0.0") || address == ClientAddress::parse("::");
}

/// Drives are not opened to whole networks by one line.
void check_open(Draft& draft, TomlTable& table, const ListenerSettings& listener) {
  const auto address = ClientAddress::parse(listener.address);
  if (address && !is_loopback(*address) && !table.has("allow") &&
      stands_nowhere(draft.document.root(), "rule")) {
    table.error("address",
                "other machines can reach {}: expected 'allow' with the permitted clients, such as "
                "allow = [\"192.168.10.0/24\"], or a [[rule]]",
                in_quotes(listener.address));
  }
}

void read_identity(TomlTable& table, ListenerSettings& listener) {
  constexpr std::array kIdentities = {Word{"address", false}, Word{"certificate", true}};
  assign(listener.counts_certificates, table.word<bool>("identity", kIdentities));
  if (listener.counts_certificates && !table.has("tls")) {
    table.error("identity", "\"certificate\" belongs to a listener with 'tls'");
  }
}

void read_access(Draft& draft, TomlTable& table, ListenerSettings& listener) {
  listener.allow = read_networks(table, "allow");
  listener.read_only = read_clients(draft, table, "read_only");
  listener.keep = read_clients(draft, table, "keep");
  read_identity(table, listener);
  const auto* allowed = table.value("allow");
  if (allowed != nullptr && is_empty_list(*allowed)) {
    table.error("allow", "expected at least one address; leave the key out to let everyone in");
  }
}

/// The gateway answers its own unit itself, and here every device has its address as unit.
void check_own_unit(const Draft& draft, TomlTable& table, drive::BusId bus) {
  for (const auto& device : draft.settings.devices) {
    if (device.bus == bus && device.address == draft.settings.status_unit &&
        !device.has_every_unit) {
      table.error("bus",
                  "unit {} is the gateway itself ([gateway] unit): device {} could not be reached; "
                  "give [gateway] unit a number that no device of this bus has, or false",
                  device.address, in_quotes(device.name));
    }
  }
}

void read_transparent(Draft& draft, TomlTable& table, ListenerSettings& listener) {
  const bool transparent = table.has("bus");
  if (const auto bus = find_named(table, "bus", draft.settings.buses)) {
    listener.bus = drive::BusId{static_cast<std::uint32_t>(*bus)};
    check_own_unit(draft, table, *listener.bus);
  } else if (transparent) {
    listener.bus = drive::BusId{~0U};  // stays transparent, of no bus
  }
  assign(listener.broadcast_reply,
         table.word<BroadcastReply>("broadcast_reply", kBroadcastReplies));
  assign(listener.broadcast_mixed, table.boolean("broadcast_mixed"));
  if (!transparent) {
    table.reject({"broadcast", "broadcast_mixed", "broadcast_reply"},
                 "belongs to a listener with 'bus'; here, a [[route]] with unit = 0 does it");
  }
  if (!listener.broadcast || !listener.bus) {
    return;
  }
  if (is_tcp(draft, *listener.bus)) {
    table.error("broadcast", in_quotes(draft.settings.bus(*listener.bus).name) +
                                 " is a Modbus TCP server, which gets no broadcasts");
  } else if (!listener.broadcast_mixed) {
    check_broadcast_mixed(draft, table, "broadcast", {*listener.bus});
  }
}

void check_port(Draft& draft, const ListenerSettings& listener) {
  const auto& all = draft.settings.listeners;
  const auto same = std::ranges::find_if(all, [&](const auto& it) { return clash(it, listener); });
  if (same != all.end()) {
    const auto first = static_cast<std::size_t>(same - all.begin());
    draft.listeners.back().error("port", "{} of {} is already used at {}", listener.port,
                                 listener.address, draft.listeners[first].place_of("port"));
  }
}

/// The first entry that fits a client counts: one within an earlier one would never.
void check_reached(const Draft& draft, std::vector<TomlTable>& tables,
                   const routing::Network& network) {
  const auto& all = draft.settings.weights;
  const auto wider =
      std::ranges::find_if(all, [&](const auto& other) { return other.network.contains(network); });
  if (wider == all.end()) {
    return;
  }
  const auto first = static_cast<std::size_t>(wider - all.begin());
  const auto text = tables.back().string("address").value_or("");
  if (network.contains(wider->network)) {
    report_twice(tables, first, "address", text);
    return;
  }
  tables.back().error("address",
                      "{} lies in the block at {}, and the first that fits counts: the narrower "
                      "one must come first",
                      in_quotes(text), tables[first].place_of("address"));
}

}  // namespace

/// The kernel gives a port to one listening socket only; a wildcard takes it on every address of
/// its kind.
bool clash(const ListenerSettings& a, const ListenerSettings& b) {
  const auto first = ClientAddress::parse(a.address);
  const auto second = ClientAddress::parse(b.address);
  if (a.port == 0 || a.port != b.port || !first || !second) {
    return false;
  }
  return *first == *second || (first->is_v4() == second->is_v4() &&
                               (is_every_interface(*first) || is_every_interface(*second)));
}

void read_listeners(Draft& draft) {
  for (auto table : draft.document.root().tables("listen")) {
    ListenerSettings listener;
    draft.listeners.push_back(table);
    listener.name = read_name(draft.listeners, draft.settings.listeners);
    read_keys(table, listener_keys(), listener);
    read_address(table, listener);
    read_handshakes(draft, table, listener);
    check_port(draft, listener);
    read_access(draft, table, listener);
    check_open(draft, table, listener);
    read_transparent(draft, table, listener);
    draft.settings.listeners.push_back(std::move(listener));
  }
}

void read_clients(Draft& draft) {
  std::vector<TomlTable> tables;  // beside settings.weights
  for (auto table : draft.document.root().tables("client")) {
    table.require_all({"address", "weight"});
    const auto text = table.string("address");
    const auto weight = table.integer("weight", {1, 100});
    const auto network =
        text ? read_network(table, "address", *table.value("address")) : std::nullopt;
    if (network) {
      tables.push_back(table);
      check_reached(draft, tables, *network);
      draft.settings.weights.push_back({*network, static_cast<unsigned>(weight.value_or(1))});
    }
  }
}

}  // namespace mbgate::config
