// SPDX-License-Identifier: Apache-2.0
#include "config/sections/sections.hpp"

#include <fmt/core.h>
#include <system_error>

namespace mbgate::config {

namespace {

constexpr std::size_t kLongestName = 64;
/// The kernel takes no longer path for a Unix socket.
constexpr std::size_t kLongestSocketPath = 107;

bool is_name_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
         c == '_' || c == '.';
}

void read_status_unit(TomlTable& table, gateway::Settings& settings) {
  const auto* unit = table.value("unit");
  if (unit == nullptr) {
    return;
  }
  const auto* number = std::get_if<std::int64_t>(&unit->data);
  const auto* truth = std::get_if<bool>(&unit->data);
  if (number != nullptr && *number >= 1 && *number <= 255) {
    settings.status_unit = static_cast<std::uint8_t>(*number);
  } else if (truth != nullptr && !*truth) {
    settings.status_unit.reset();
  } else {
    table.report_expected("unit", *unit, "an integer from 1 to 255 or false");
  }
}

/// The folder that `profiles` names, relative to the folder of the file.
std::optional<std::filesystem::path> read_profiles(TomlTable& table) {
  const auto named = table.string("profiles");
  if (!named) {
    return std::nullopt;
  }
  const Position position = table.value_position("profiles");
  auto folder = std::filesystem::path(table.document().name(position)).parent_path() / *named;
  std::error_code ignored;
  if (!std::filesystem::is_directory(folder, ignored)) {
    table.error("profiles", "there is no folder " + in_quotes(folder.string()));
  }
  return folder;
}

}  // namespace

void read_gateway(Draft& draft, const std::optional<std::filesystem::path>& profile_folder) {
  std::optional<std::filesystem::path> folder;
  if (auto table = draft.document.root().table("gateway")) {
    read_status_unit(*table, draft.settings);
    read_keys(*table, gateway_keys(), draft.settings);
    read_socket_path(*table, "signer", draft.settings.signer);
    folder = read_profiles(*table);
  }
  if (profile_folder) {
    folder = profile_folder;
  }
  if (folder) {
    draft.library = ProfileLibrary({*folder});
  }
}

bool is_tcp(const Draft& draft, drive::BusId bus) {
  return index(bus) < draft.settings.buses.size() &&
         draft.settings.bus(bus).line.framing == bus::Framing::tcp;
}

std::string read_name(TomlTable& table) {
  table.require("name");
  auto name = table.string("name");
  if (!name) {
    return {};
  }
  if (name->empty() || name->size() > kLongestName || !std::ranges::all_of(*name, is_name_letter)) {
    table.report_expected("name", *table.value("name"),
                          "1 to 64 letters, digits, '-', '_' and '.'");
  }
  return *std::move(name);
}

void read_socket_path(TomlTable& table, std::string_view key, std::string& path,
                      std::string_view or_else) {
  const auto socket = table.string(key);
  if (!socket) {
    return;
  }
  path = *socket;
  const bool is_none = socket->empty() && !or_else.empty();
  if (!is_none && (!socket->starts_with('/') || socket->size() > kLongestSocketPath)) {
    table.report_expected(key, *table.value(key), "an absolute path of at most 107 characters{}",
                          or_else);
  }
}

std::string line_of(const Draft& draft, Position position) {
  return fmt::format("{}:{}", draft.document.name(position), position.line);
}

bool stands_nowhere(TomlTable root, std::string_view key) {
  const auto* found = root.value(key);
  return found == nullptr || is_empty_list(*found);
}

std::optional<routing::Network> read_network(TomlTable& table, std::string_view key,
                                             const TomlValue& found) {
  const auto* text = std::get_if<std::string>(&found.data);
  const auto network = text == nullptr ? std::nullopt : routing::Network::parse(*text);
  if (!network) {
    table.report_expected(key, found,
                          "an address or a block without bits beyond its prefix, such as "
                          "\"192.168.10.0/24\"");
  }
  return network;
}

routing::NetworkList read_networks(TomlTable& table, std::string_view key) {
  routing::NetworkList networks;
  for (const auto& [text, position] : table.strings(key).value_or(std::vector<TomlText>())) {
    if (const auto network = read_network(table, key, {position, text})) {
      networks.push_back(*network);
    }
  }
  return networks;
}

routing::ClientList read_clients(Draft& draft, TomlTable& table, std::string_view key) {
  constexpr std::string_view kRole = "role:";
  constexpr std::string_view kCertificate = "certificate:";
  routing::ClientList clients;
  for (const auto& [text, position] : table.strings(key).value_or(std::vector<TomlText>())) {
    const bool is_role = text.starts_with(kRole);
    const bool is_certificate = text.starts_with(kCertificate) && text != kCertificate;
    if ((is_role || is_certificate) && draft.settings.tls.empty()) {
      table.document().error(position,
                             "{}: {} is for clients with a certificate: there is no [[tls]]", key,
                             in_quotes(text));
    } else if (is_role) {
      clients.roles.push_back(text.substr(kRole.size()));
    } else if (is_certificate) {
      clients.certificates.push_back(text.substr(kCertificate.size()));
    } else if (const auto network = routing::Network::parse(text)) {
      clients.networks.push_back(*network);
    } else {
      table.report_expected(key, {position, text},
                            "an address or a block without bits beyond its prefix, such as "
                            "\"192.168.10.0/24\", or, of clients with TLS, \"role:NAME\" or "
                            "\"certificate:NAME\"");
    }
  }
  return clients;
}

void report_twice(std::vector<TomlTable>& tables, std::size_t first, std::string_view key,
                  std::string_view what) {
  auto& again = tables.back();
  again.error(key, "{} is already used at {}", in_quotes(what), tables[first].place_of(key));
}

}  // namespace mbgate::config
