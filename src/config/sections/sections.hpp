// SPDX-License-Identifier: Apache-2.0
// One function a section of the configuration, each filling its part of the draft. They go on after
// an error, so that all errors of meaning are reported at once; a wrong entry keeps its place in
// the settings.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/keys/keys.hpp"
#include "config/profiles/profile_library.hpp"
#include "config/toml/suggestion.hpp"
#include "config/toml/toml_reader.hpp"
#include "config/toml/unit_range.hpp"
#include "gateway/settings.hpp"

namespace mbgate::config {

/// Settings in the making, and beside each entry the table it was read from.
struct Draft {
  Draft(TomlDocument& source, ProfileFolders folders)
      : document(source), library(std::move(folders)) {}

  TomlDocument& document;
  ProfileLibrary library;
  gateway::Settings settings;
  std::vector<TomlTable> listeners;
  std::vector<TomlTable> buses;
  std::vector<TomlTable> devices;
  std::vector<bool> profile_known;  ///< beside settings.devices; false where `profile` is wrong
  std::vector<TomlTable> routes;
  std::vector<std::optional<UnitRange>> route_units;  ///< none where `unit` is wrong
};

/// `profile_folder`: the one of the command line, which goes before that of the file.
void read_gateway(Draft& draft, const std::optional<std::filesystem::path>& profile_folder);
void read_buses(Draft& draft);
void read_devices(Draft& draft);
void read_listeners(Draft& draft);
void read_routes(Draft& draft);
/// What no section can see alone: clashes between routes, ways that lead nowhere, deadlines.
void check_whole(Draft& draft);

/// [[client]]: whose turn comes more often.
void read_clients(Draft& draft);

/// `name` of a table: required, and fit to be printed in a log line and a list of labels.
std::string read_name(TomlTable& table);

/// `mode`, what a line of that mode has (`device`, `parity`, ...; or `host`, `port`), and the plain
/// keys of a bus. Returns what the bus is, as far as that is certain.
Lines read_line(TomlTable& table, bus::BusSettings& settings);

/// Warnings of a serial line: what is possible, but seldom meant.
void check_habits(TomlTable& table, const bus::LineSettings& line);

/// What kind of drive a device is: `profile`, `word_order`, `values32`, ... Its bus is known.
void read_drive(Draft& draft, TomlTable& table, drive::Device& device);

/// Where a table with times stands.
struct TimingOrigin {
  Lines lines = Lines::any;         ///< what the bus may be
  bool longest_quarantine = false;  ///< the bus of the device states `quarantine_max`
};

/// What buses state for their devices, and devices for themselves: `response_timeout`, `retries`,
/// `quarantine`, `offline_after`, ...
void read_shared_timing(TomlTable& table, TimingOrigin origin, drive::DeviceTiming& timing);

/// Stops of the device's own, added to those of its profile. Its values are known.
void read_own_stops(TomlTable& table, drive::Device& device);

/// `failsafe`: writes in the function that the device takes. Everything else of it is known.
std::vector<modbus::Request> read_failsafe(TomlTable& table, const drive::Device& device);

/// `writer`, `failsafe`, ... of a device.
gateway::DeviceGuard read_guard(TomlTable& table, const drive::Device& device);

/// An address or a block in CIDR form, read from `found` at `key`; nothing if it is neither.
std::optional<routing::Network> read_network(TomlTable& table, std::string_view key,
                                             const TomlValue& found);

/// A list of addresses and blocks.
routing::NetworkList read_networks(TomlTable& table, std::string_view key);

/// Values of the device's own, added to those of its profile. `file` is nullptr where the profile
/// has none.
void read_own_values(TomlTable& table, const ProfileFile* file, drive::Device& device);

/// A broadcast to `bus`, set up at `key`: do devices of different profiles hear it?
void check_broadcast_mixed(Draft& draft, TomlTable& table, std::string_view key,
                           const std::vector<drive::BusId>& buses);

/// Windows, word orders and broadcasts of routes against the devices that they reach.
void check_routes(Draft& draft);

/// Deadlines of routes against the times of the devices that they reach.
void check_deadlines(Draft& draft);

/// Is it a connection to a Modbus TCP server? False for an unknown bus.
bool is_tcp(const Draft& draft, drive::BusId bus);

/// What a route lets through: `access`, `functions`, `[[route.registers]]`, `deadline`.
void read_route_rules(TomlTable& table, routing::Route& route, bool broadcast);

/// "conf/x.toml:12:8", to name a second place in a message.
std::string place(const TomlDocument& document, Position position);

/// Reports what the newest of `tables` shares with an earlier one: the value of `key`, called
/// `what`.
void report_twice(std::vector<TomlTable>& tables, std::size_t first, std::string_view key,
                  std::string_view what);

/// The section that an entry of the settings stands in.
template <typename Named>
inline constexpr std::string_view kSection;
template <>
inline constexpr std::string_view kSection<gateway::ListenerSettings> = "[[listen]]";
template <>
inline constexpr std::string_view kSection<bus::BusSettings> = "[[bus]]";
template <>
inline constexpr std::string_view kSection<drive::Device> = "[[device]]";

/// The entry whose name stands at `key`; unknown names are reported with a suggestion.
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
  std::vector<std::string_view> names;
  names.reserve(all.size());
  for (const auto& candidate : all) {
    names.push_back(candidate.name);
  }
  table.error(key, "no " + std::string(kSection<Named>) + " is named " + in_quotes(*name) +
                       did_you_mean(*name, names));
  return std::nullopt;
}

/// Reports a name that an earlier entry has; the newest entry is not yet among `all`.
template <typename Named>
void check_name(std::vector<TomlTable>& tables, const std::vector<Named>& all,
                std::string_view name) {
  const auto entry = std::ranges::find(all, name, &Named::name);
  if (!name.empty() && entry != all.end()) {
    report_twice(tables, static_cast<std::size_t>(entry - all.begin()), "name", name);
  }
}

/// The place in the settings of an identifier.
template <typename Id>
constexpr std::size_t index(Id id) {
  return static_cast<std::size_t>(id);
}

}  // namespace mbgate::config
