// SPDX-License-Identifier: Apache-2.0
#include <sys/stat.h>

#include <algorithm>
#include <fmt/format.h>

#include "config/sections/sections.hpp"
#include "config/toml/toml_value.hpp"

namespace mbgate::config {
namespace {

void check_reopening(TomlTable& table, const bus::BusSettings& settings) {
  if (settings.reopen_max < settings.reopen_min) {
    table.error(table.has("reopen_max") ? "reopen_max" : "reopen_min",
                "reopen_max ({}) is shorter than reopen_min ({})", to_text(settings.reopen_max),
                to_text(settings.reopen_min));
  }
  if (settings.hung_max < settings.hung_after) {
    table.error(table.has("hung_max") ? "hung_max" : "hung_after",
                "hung_max ({}) is shorter than hung_after ({})", to_text(settings.hung_max),
                to_text(settings.hung_after));
  }
}

/// What may still be under way on a line that works must be over by then.
void check_stop_deadline(TomlTable& table, const bus::BusSettings& settings) {
  const auto least = bus::least_stop_deadline(settings);
  if (settings.stop_deadline && *settings.stop_deadline < least) {
    table.error("stop_deadline",
                "{} is shorter than {}: stop_wait and 1.1 times the longest frame at {} baud",
                to_text(*settings.stop_deadline), to_text(least),
                fmt::underlying(settings.line.baud));
  }
}

void check_frame_gap(TomlTable& table, const bus::BusSettings& settings) {
  if (settings.line.framing != bus::Framing::rtu) {
    return;  // ASCII frames are told apart by their ends
  }
  const auto t3_5 = modbus::RtuTiming(settings.line.baud, settings.line.format).t3_5();
  if (settings.frame_gap && *settings.frame_gap < t3_5) {
    table.warning("frame_gap",
                  "{} is shorter than t3.5, {} at {} baud: only for devices that allow it",
                  to_text(*settings.frame_gap), to_text(t3_5), fmt::underlying(settings.line.baud));
  }
}

/// Without transaction identifiers only the unit and the order tell whose an answer is.
void check_identifiers(TomlTable& table, const bus::BusSettings& settings) {
  if (settings.check_transaction) {
    return;
  }
  if (settings.outstanding > 1) {
    table.error("outstanding", "check_transaction = false needs outstanding = 1");
  }
  if (!settings.check_unit) {
    table.error("check_transaction", "false needs check_unit = true");
  }
}

/// What the system has behind the path; nothing if it is not there, or is no device.
std::optional<dev_t> port_behind(const std::string& path) {
  struct stat status {};
  return !path.empty() && ::stat(path.c_str(), &status) == 0 && S_ISCHR(status.st_mode)
             ? std::optional(status.st_rdev)
             : std::nullopt;
}

/// Two buses on one line would talk into each other's transactions, and a drive behind two
/// connections would have two orders of its writes.
bool same_line(const bus::LineSettings& a, const bus::LineSettings& b) {
  if (a.remote || b.remote) {
    return a.remote == b.remote && !a.remote->host.empty();
  }
  const auto port = port_behind(a.device);
  return !a.device.empty() && (a.device == b.device || (port && port == port_behind(b.device)));
}

std::string line_text(const bus::LineSettings& line) {
  return in_quotes(line.device.empty() ? fmt::format("{}:{}", line.remote->host, line.remote->port)
                                       : line.device);
}

void check_line(Draft& draft, const bus::BusSettings& settings) {
  const auto& all = draft.settings.buses;
  const auto same = std::ranges::find_if(
      all, [&](const auto& other) { return same_line(settings.line, other.line); });
  if (same == all.end()) {
    return;
  }
  const auto key = [](TomlTable& table) { return table.has("host") ? "host" : "device"; };
  TomlTable& other = draft.buses[static_cast<std::size_t>(same - all.begin())];
  const std::string line = line_text(settings.line);
  const std::string known = line_text(same->line);
  draft.buses.back().error(key(draft.buses.back()), "{}{} is already used at {} by bus {}", line,
                           line == known ? "" : fmt::format(", the same line as {},", known),
                           other.place_of(key(other)), in_quotes(same->name));
}

/// Of a Modbus TCP server that is reached over TLS.
void read_peer(Draft& draft, TomlTable& table, bus::LineSettings& line, Lines lines) {
  const auto tls = find_named(table, "tls", draft.settings.tls);
  const auto server_name = table.string("server_name");
  const bool is_server = lines == Lines::server;
  if (!is_server && lines != Lines::any) {
    table.reject({"tls", "server_name"},
                 R"(belongs to mode = "tcp": a serial device server speaks no TLS)");
  }
  if (is_server && table.has("server_name") && !table.has("tls")) {
    table.error("server_name", "is the name in the certificate of the server: expected 'tls' too");
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

using namespace std::chrono_literals;

/// How long it may become must be no shorter than what it begins with. Where nobody states it, it
/// makes room for a slow device by itself.
void check_longest_quarantine(TomlTable& table, bool inherited, drive::DeviceTiming& timing) {
  const auto first = timing.quarantine_or_default();
  if (!table.has("quarantine_max") && !inherited) {
    timing.quarantine_max = std::max(drive::DeviceTiming().quarantine_max, first);
    return;
  }
  if (timing.quarantine_max >= first) {
    return;
  }
  for (const auto* key : {"quarantine_max", "quarantine", "response_timeout", "profile"}) {
    if (table.has(key)) {  // otherwise the error was reported at the bus
      table.error(key, "quarantine_max ({}) is shorter than quarantine ({}{}",
                  to_text(timing.quarantine_max), to_text(first),
                  timing.quarantine ? ")" : ", one more response timeout)");
      return;
    }
  }
}

void check_quarantine(TomlTable& table, TimingOrigin origin, drive::DeviceTiming& timing) {
  if (origin.has_identifiers) {
    table.reject(
        {"quarantine", "quarantine_max"},
        "belongs to serial lines and to check_transaction = false: transaction identifiers "
        "tell whose a late response is");
    return;
  }
  if (table.has("quarantine") && timing.quarantine == 0s) {
    table.warning("quarantine",
                  "without one, a late response can be taken for the answer to the next request");
  }
  check_longest_quarantine(table, origin.longest_quarantine, timing);
}

/// What is longer than half of the response timeout is shortened.
void check_probe_timeout(TomlTable& table, const drive::DeviceTiming& timing) {
  if (!timing.probe_timeout || *timing.probe_timeout <= timing.response_timeout / 2) {
    return;
  }
  for (const auto* key : {"probe_timeout", "response_timeout", "profile"}) {
    if (table.has(key)) {  // otherwise the error was reported at the bus
      table.warning(key,
                    "probe_timeout ({}) is longer than half of response_timeout ({}): probes wait "
                    "for that half",
                    to_text(*timing.probe_timeout), to_text(timing.response_timeout));
      return;
    }
  }
}

}  // namespace

void read_buses(Draft& draft) {
  for (auto table : draft.document.root().tables("bus")) {
    bus::BusSettings settings;
    draft.buses.push_back(table);
    settings.name = read_name(draft.buses, draft.settings.buses);
    const Lines lines = read_line(table, settings);
    read_peer(draft, table, settings.line, lines);
    check_line(draft, settings);
    read_shared_timing(table, {.has_identifiers = settings.has_identifiers()}, settings.timing);
    check_reopening(table, settings);
    check_stop_deadline(table, settings);
    check_frame_gap(table, settings);
    check_identifiers(table, settings);
    draft.settings.buses.push_back(std::move(settings));
  }
}

void read_shared_timing(TomlTable& table, TimingOrigin origin, drive::DeviceTiming& timing) {
  read_keys(table, timing_keys(), timing);
  check_quarantine(table, origin, timing);
  check_probe_timeout(table, timing);
}

}  // namespace mbgate::config
