// SPDX-License-Identifier: Apache-2.0
#include "config/sections/sections.hpp"
#include "config/toml/duration_text.hpp"

namespace mbgate::config {
namespace {

void check_reopening(TomlTable& table, const bus::BusSettings& settings) {
  if (settings.reopen_max < settings.reopen_min) {
    table.error(table.has("reopen_max") ? "reopen_max" : "reopen_min",
                "reopen_max (" + to_text(settings.reopen_max) + ") is shorter than reopen_min (" +
                    to_text(settings.reopen_min) + ")");
  }
  if (settings.hung_max < settings.hung_after) {
    table.error(table.has("hung_max") ? "hung_max" : "hung_after",
                "hung_max (" + to_text(settings.hung_max) + ") is shorter than hung_after (" +
                    to_text(settings.hung_after) + ")");
  }
}

/// What may still be under way on a line that works must be over by then.
void check_stop_deadline(TomlTable& table, const bus::BusSettings& settings) {
  const auto least = bus::least_stop_deadline(settings);
  if (settings.stop_deadline && *settings.stop_deadline < least) {
    table.error("stop_deadline",
                to_text(*settings.stop_deadline) + " is shorter than " + to_text(least) +
                    ": stop_wait and 1.1 times the longest frame at " +
                    std::to_string(static_cast<std::uint32_t>(settings.line.baud)) + " baud");
  }
}

void check_frame_gap(TomlTable& table, const bus::BusSettings& settings) {
  if (settings.line.framing != bus::Framing::rtu) {
    return;  // ASCII frames are told apart by their ends
  }
  const auto t3_5 = modbus::RtuTiming(settings.line.baud, settings.line.format).t3_5();
  if (settings.frame_gap && *settings.frame_gap < t3_5) {
    table.warning("frame_gap", to_text(*settings.frame_gap) + " is shorter than t3.5, " +
                                   to_text(t3_5) + " at " +
                                   std::to_string(static_cast<std::uint32_t>(settings.line.baud)) +
                                   " baud: only for devices that allow it");
  }
}

/// Two buses on one line would talk into each other's transactions. A Modbus TCP server keeps its
/// connections apart.
bool same_line(const bus::LineSettings& a, const bus::LineSettings& b) {
  const bool tcp = a.framing == bus::Framing::tcp || b.framing == bus::Framing::tcp;
  return !tcp && !a.device.empty() && (a.device == b.device || (a.remote && a.remote == b.remote));
}

void check_line(Draft& draft, const bus::BusSettings& settings) {
  const auto& all = draft.settings.buses;
  const auto same = std::ranges::find_if(
      all, [&](const auto& other) { return same_line(settings.line, other.line); });
  if (same != all.end()) {
    report_twice(draft.buses, static_cast<std::size_t>(same - all.begin()), "device",
                 settings.line.device);
  }
}

/// Of a Modbus TCP server that is reached over TLS.
void read_peer(Draft& draft, TomlTable& table, bus::LineSettings& line, Lines lines) {
  const auto tls = find_named(table, "tls", draft.settings.tls);
  const auto server_name = table.string("server_name");
  const bool is_server = lines == Lines::server;
  for (const auto* key : {"tls", "server_name"}) {
    if (table.has(key) && !is_server && lines != Lines::any) {
      table.error(key, R"(belongs to mode = "tcp": a serial device server speaks no TLS)");
    }
  }
  if (is_server && table.has("server_name") && !table.has("tls")) {
    table.error("server_name", "is what the certificate of the server is for: expected 'tls' too");
  }
  if (server_name && server_name->empty()) {
    table.error("server_name", "expected a host name or an IP address, found an empty string");
  }
  if (!is_server || !table.has("tls") || !line.remote) {
    return;
  }
  if (!table.has("port")) {
    line.remote->port = kSecurePort;
  }
  if (tls) {
    const auto& found = draft.settings.tls[*tls];
    line.tls = bus::TlsPeer{found.certificate,     found.key,
                            found.authorities,     found.crl,
                            draft.settings.signer, server_name.value_or(line.remote->host)};
  }
}

}  // namespace

void read_buses(Draft& draft) {
  for (auto table : draft.document.root().tables("bus")) {
    bus::BusSettings settings;
    draft.buses.push_back(table);
    settings.name = read_name(table);
    check_name(draft.buses, draft.settings.buses, settings.name);
    const Lines lines = read_line(table, settings);
    read_peer(draft, table, settings.line, lines);
    check_line(draft, settings);
    read_shared_timing(table, {.lines = lines}, settings.timing);
    check_reopening(table, settings);
    check_stop_deadline(table, settings);
    check_frame_gap(table, settings);
    draft.settings.buses.push_back(std::move(settings));
  }
}

}  // namespace mbgate::config
