// SPDX-License-Identifier: Apache-2.0
#include "config/duration_text.hpp"
#include "config/sections.hpp"

namespace mbgate::config {
namespace {

using namespace std::chrono_literals;

constexpr DurationRange kReopen = {10ms, 1h};

void read_times(TomlTable& table, bus::BusSettings& settings) {
  read_shared_timing(table, {.tcp = settings.line.framing == bus::Framing::tcp}, settings.timing);
  assign(settings.turnaround, table.duration("turnaround", {0s, 1min}));
  assign(settings.frame_gap, table.duration("frame_gap", {0s, 1s}));
  assign(settings.frame_slack, table.duration("frame_slack", {1ms, 10s}));
  if (settings.line.framing == bus::Framing::ascii && table.has("frame_slack")) {
    table.error("frame_slack", "belongs to mode = \"rtu\": ASCII characters may be 1s apart");
  }
  assign(settings.listen_first, table.duration("listen_first", {0s, 1min}));
  assign(settings.settle, table.duration("settle", {0s, 1min}));
  assign(settings.reopen_min, table.duration("reopen_min", kReopen));
  assign(settings.reopen_max, table.duration("reopen_max", kReopen));
  if (settings.reopen_max < settings.reopen_min) {
    table.error(table.has("reopen_max") ? "reopen_max" : "reopen_min",
                "reopen_max (" + to_text(settings.reopen_max) + ") is shorter than reopen_min (" +
                    to_text(settings.reopen_min) + ")");
  }
}

void read_hung(TomlTable& table, bus::BusSettings& settings) {
  assign(settings.hung_after, table.duration("hung_after", {1s, 24h, true}));
  assign(settings.hung_requests, table.integer("hung_requests", {1, 1'000'000}));
  assign(settings.hung_max, table.duration("hung_max", {1s, 24h}));
  if (settings.hung_max < settings.hung_after) {
    table.error(table.has("hung_max") ? "hung_max" : "hung_after",
                "hung_max (" + to_text(settings.hung_max) + ") is shorter than hung_after (" +
                    to_text(settings.hung_after) + ")");
  }
  for (const auto* key : {"hung_after", "hung_requests", "hung_max"}) {
    if (settings.line.remote && table.has(key)) {
      table.error(key, "belongs to a serial port of this machine");
    }
  }
}

/// What may still be under way on a line that works must be over by then.
void read_stop_deadline(TomlTable& table, bus::BusSettings& settings) {
  if (settings.line.framing == bus::Framing::tcp) {
    if (table.has("stop_deadline")) {
      table.error("stop_deadline", "belongs to serial lines: a connection needs no silence");
    }
    return;
  }
  assign(settings.stop_deadline, table.duration("stop_deadline", {1ms, 1min}));
  const auto least = bus::least_stop_deadline(settings);
  if (settings.stop_deadline && *settings.stop_deadline < least) {
    table.error("stop_deadline",
                to_text(*settings.stop_deadline) + " is shorter than " + to_text(least) +
                    ": stop_wait and 1.1 times the longest frame at " +
                    std::to_string(static_cast<std::uint32_t>(settings.line.baud)) + " baud");
  }
}

void read_queueing(TomlTable& table, bus::BusSettings& settings) {
  assign(settings.queue, table.integer("queue", {1, 1'000'000}));
  assign(settings.coalesce, table.boolean("coalesce"));
  assign(settings.merge, table.boolean("merge"));
  assign(settings.burst, table.integer("burst", {1, 1000}));
  assign(settings.stop_wait, table.duration("stop_wait", {0s, 10s}));
  read_stop_deadline(table, settings);
  const auto* share = table.value("probe_share");
  if (share == nullptr) {
    return;
  }
  const auto* percent = std::get_if<std::int64_t>(&share->data);
  if (percent != nullptr && *percent >= 1 && *percent <= 100) {
    settings.probe_share = static_cast<unsigned>(*percent);
  } else {
    table.report_expected("probe_share", *share,
                          "percent of the bus's time, an integer from 1 to 100");
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

}  // namespace

void read_buses(Draft& draft) {
  for (auto table : draft.document.root().tables("bus")) {
    bus::BusSettings settings;
    draft.buses.push_back(table);
    settings.name = read_name(table);
    check_name(draft.buses, draft.settings.buses, settings.name);
    read_line(table, settings);
    check_line(draft, settings);
    read_times(table, settings);
    read_hung(table, settings);
    check_frame_gap(table, settings);
    read_queueing(table, settings);
    draft.settings.buses.push_back(std::move(settings));
  }
}

}  // namespace mbgate::config
