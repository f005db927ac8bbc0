// SPDX-License-Identifier: Apache-2.0
// One function for each section of the configuration; each fills its part of the draft. They go on
// after an error, so that all errors of meaning are reported at once. A wrong entry keeps its place
// in the settings.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/diagnostic.hpp"
#include "config/keys/keys.hpp"
#include "config/profiles/profile_library.hpp"
#include "config/toml/match_entry.hpp"
#include "config/toml/suggestion.hpp"
#include "config/toml/toml_reader.hpp"
#include "gateway/settings.hpp"
#include "routing/route_table.hpp"

namespace mbgate::config {

/// Of Modbus/TCP Security (MB-TCP-Security v36).
inline constexpr std::uint16_t kSecurePort = 802;

/// Unit identifiers, and addresses behind a server (MBAP has a byte for them).
inline constexpr IntegerRange kUnits = {0, 255};
/// Of devices on a serial line (Serial Line V1.02, 2.2).
inline constexpr IntegerRange kSerialAddresses = {1, 247};
/// Of an address at which nobody can listen (RFC 4291, 2.5.6).
inline constexpr std::string_view kNoScope =
    "a link-local address needs an interface, which cannot be named here: expected another address "
    "of this machine, or \"::\"";
/// Who confirms a broadcast to its client: the gateway, or nobody.
inline constexpr std::array kBroadcastReplies = {Word{"echo", routing::BroadcastReply::echo},
                                                 Word{"none", routing::BroadcastReply::none}};

/// Settings that are being read, and for each entry the table that it was read from.
struct Draft {
  Draft(TomlDocument& source, ProfileFolders folders)
      : document(source), library(std::move(folders)) {}

  TomlDocument& document;
  ProfileLibrary library;
  gateway::Settings settings;
  std::vector<TomlTable> tls;
  std::vector<TomlTable> listeners;
  std::vector<TomlTable> buses;
  std::vector<TomlTable> devices;
  std::vector<bool> profile_known;  ///< beside settings.devices; false where `profile` is wrong
  std::vector<TomlTable> routes;
  std::vector<std::optional<UnitRange>> route_units;  ///< none where `unit` is wrong
  std::vector<TomlTable> rules;
  std::vector<TomlTable> group_tables;  ///< beside `groups`
  std::vector<routing::ClientGroup> groups;
  std::vector<bool> groups_named;  ///< beside `groups`: in a rule
};

/// `profile_folder`: from the command line; it takes precedence over that of the file.
void read_gateway(Draft& draft, const std::optional<std::filesystem::path>& profile_folder);
/// [[tls]]: certificates and keys, for listeners and buses that name them.
void read_tls(Draft& draft);
void read_buses(Draft& draft);
void read_devices(Draft& draft);
void read_listeners(Draft& draft);
void read_routes(Draft& draft);
/// Checks that need several sections: clashes between routes, routes that lead nowhere, deadlines.
void check_whole(Draft& draft);

/// [http]: the Unix socket, and the addresses at which it is read over TCP. The listeners are
/// known.
void read_http(Draft& draft);

/// [[group]] and [[rule]]: who may do what. Listeners and devices are known.
void read_rules(Draft& draft);

/// `registers` of a rule: "holding 0x7C-0x80", "motion commands", ...
routing::RegisterSet read_rule_registers(TomlTable& table);

/// Rules that can never match, or deny nothing to clients with TLS, and groups that none names.
void check_rules(Draft& draft, const routing::RouteTable& table);

/// "mbgate.toml:12".
std::string line_of(const Draft& draft, Position position);

/// Where the keys stand that deny requests. All sections have been read, without an error.
KeyPlaces find_key_places(Draft& draft);

/// [[client]]: which clients get more turns.
void read_clients(Draft& draft);

/// `name` of a table: required, and with characters that can be printed in the journal and as a
/// label.
std::string read_name(TomlTable& table);

/// `mode`, what a line of that mode has (`device`, `parity`, ...; or `host`, `port`), and the plain
/// keys of a bus. Returns what the bus is connected to, as far as that is certain.
Lines read_line(TomlTable& table, bus::BusSettings& settings);

/// Warnings for a serial line: settings that are possible, but seldom intended.
void check_habits(TomlTable& table, const bus::LineSettings& line);

/// What kind of drive a device is: `profile`, `word_order`, `values32`, ... Its bus is known.
void read_drive(Draft& draft, TomlTable& table, drive::Device& device);

/// Where a table with times is.
struct TimingOrigin {
  bool has_identifiers = false;     ///< late responses are known by their identifiers
  bool longest_quarantine = false;  ///< the bus of the device states `quarantine_max`
};

/// Times that a bus can set for its devices, and a device for itself: `response_timeout`,
/// `retries`, `quarantine`, `offline_after`, ...
void read_shared_timing(TomlTable& table, TimingOrigin origin, drive::DeviceTiming& timing);

/// The device's own stops, added to those of its profile. Its values must have been read.
void read_own_stops(TomlTable& table, drive::Device& device);

/// `failsafe`: the writes, with the function code that the device takes. Everything else of the
/// device must have been read.
std::vector<modbus::Request> read_failsafe(TomlTable& table, const drive::Device& device);

/// `writer`, `failsafe`, ... of a device.
gateway::DeviceGuard read_guard(Draft& draft, TomlTable& table, const drive::Device& device);

/// An address or a block in CIDR form, read from `found` at `key`; nothing if it is neither.
std::optional<routing::Network> read_network(TomlTable& table, std::string_view key,
                                             const TomlValue& found);

/// The absolute path of a Unix socket at `key`; a wrong one is reported, and taken all the same.
/// `or_else`: what may stand there too, for the message.
void read_socket_path(TomlTable& table, std::string_view key, std::string& path,
                      std::string_view or_else = {});

/// Is there no [[key]]? An empty list has none either.
bool stands_nowhere(TomlTable root, std::string_view key);

/// A list of addresses and blocks.
routing::NetworkList read_networks(TomlTable& table, std::string_view key);
/// A list of addresses and blocks, "role:NAME" and "certificate:NAME".
routing::ClientList read_clients(Draft& draft, TomlTable& table, std::string_view key);

/// The device's own values, added to those of its profile. `file` is nullptr if the profile has no
/// file.
void read_own_values(TomlTable& table, const ProfileFile* file, drive::Device& device);

/// A broadcast to `bus`, set up at `key`: do devices of different profiles hear it?
void check_broadcast_mixed(Draft& draft, TomlTable& table, std::string_view key,
                           const std::vector<drive::BusId>& buses);

/// Windows, word orders and broadcasts of routes against the devices that they reach.
void check_routes(Draft& draft);

/// A time that was computed, in whole milliseconds.
std::string rounded(std::chrono::nanoseconds duration);

/// Do these take a port from each other?
bool clash(const gateway::ListenerSettings& a, const gateway::ListenerSettings& b);

/// Is it a connection to a Modbus TCP server? False for an unknown bus.
bool is_tcp(const Draft& draft, drive::BusId bus);

/// What a route lets through: `access`, `functions`, `[[route.registers]]`, `deadline`.
void read_route_rules(const Draft& draft, TomlTable& table, routing::Route& route, bool broadcast);

/// Reports that the newest of `tables` has the same value of `key` as an earlier one; `what`: that
/// value as text.
void report_twice(std::vector<TomlTable>& tables, std::size_t first, std::string_view key,
                  std::string_view what);

/// Do its clients show certificates?
template <typename Listener>
bool has_tls(const Listener& listener) {
  if constexpr (requires { listener.tls; }) {
    return listener.tls.has_value();
  } else {
    return false;
  }
}

/// The section that an entry of the settings belongs to.
template <typename Named>
inline constexpr std::string_view kSection;
template <>
inline constexpr std::string_view kSection<gateway::ListenerSettings> = "[[listen]]";
template <>
inline constexpr std::string_view kSection<gateway::TlsSettings> = "[[tls]]";
template <>
inline constexpr std::string_view kSection<bus::BusSettings> = "[[bus]]";
template <>
inline constexpr std::string_view kSection<drive::Device> = "[[device]]";
template <>
inline constexpr std::string_view kSection<routing::ClientGroup> = "[[group]]";

template <typename Named>
std::vector<std::string_view> names_of(const std::vector<Named>& all) {
  std::vector<std::string_view> names;
  names.reserve(all.size());
  for (const auto& it : all) {
    names.push_back(it.name);
  }
  return names;
}

/// The index of the entry that `key` names; an unknown name is reported with a suggestion.
template <typename Named>
std::optional<std::size_t> find_named(TomlTable& table, std::string_view key,
                                      const std::vector<Named>& all) {
  const auto name = table.string(key);
  if (!name) {
    return std::nullopt;
  }
  const auto entry = std::ranges::find(all, *name, &Named::name);
  if (entry != all.end()) {
    return static_cast<std::size_t>(entry - all.begin());
  }
  table.error(key, "no {} is named {}{}", kSection<Named>, in_quotes(*name),
              did_you_mean(*name, names_of(all)));
  return std::nullopt;
}

/// Reports a name that an earlier entry has; the newest entry is not yet among `all`.
template <typename Named>
std::string read_name(std::vector<TomlTable>& tables, const std::vector<Named>& all) {
  std::string name = read_name(tables.back());
  const auto entry = std::ranges::find(all, name, &Named::name);
  if (!name.empty() && entry != all.end()) {
    report_twice(tables, static_cast<std::size_t>(entry - all.begin()), "name", name);
  }
  return name;
}

/// The index in the settings that an identifier stands for.
template <typename Id>
constexpr std::size_t index(Id id) {
  return static_cast<std::size_t>(id);
}

}  // namespace mbgate::config
