// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <limits>

#include "config/duration_text.hpp"
#include "config/sections.hpp"

namespace mbgate::config {
namespace {

using modbus::Parity;
using namespace std::chrono_literals;

constexpr std::array kModes = {Word{"rtu", true}};
constexpr std::array kParities = {Word{"none", Parity::none}, Word{"even", Parity::even},
                                  Word{"odd", Parity::odd}};
constexpr std::array kDirections = {
    Word{"off", bus::Rs485::off}, Word{"kernel", bus::Rs485::kernel}, Word{"rts", bus::Rs485::rts}};

constexpr DurationRange kReopen = {10ms, 1h};

void read_line(TomlTable& table, bus::LineSettings& line) {
  table.word<bool>("mode", kModes);
  if (table.require("device")) {
    assign(line.device, table.string("device"));
    if (line.device.empty() && std::get_if<std::string>(&table.value("device")->data) != nullptr) {
      table.error("device", "expected the path of a serial port, found an empty string");
    }
  }
  assign(line.baud, table.integer("baud", {1, std::numeric_limits<std::uint32_t>::max()}));
  const auto data_bits = table.integer("data_bits", {5, 8});
  if (data_bits && *data_bits != 8) {
    table.error("data_bits", "RTU characters have 8 data bits (Serial Line V1.02, 2.5.1), found " +
                                 std::to_string(*data_bits));
  }
  assign(line.format.parity, table.word<Parity>("parity", kParities));
  assign(line.format.stop_bits, table.integer("stop_bits", {1, 2}));
  assign(line.rs485, table.word<bus::Rs485>("rs485", kDirections));
  assign(line.echo, table.boolean("echo"));
  assign(line.low_latency, table.boolean("low_latency"));
}

void read_times(TomlTable& table, bus::BusSettings& settings) {
  assign(settings.timing.response_timeout, table.duration("response_timeout", {1ms, 1h}));
  assign(settings.timing.retries, table.integer("retries", {0, 100}));
  assign(settings.turnaround, table.duration("turnaround", {0s, 1min}));
  assign(settings.frame_gap, table.duration("frame_gap", {0s, 1s}));
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

void check_frame_gap(TomlTable& table, const bus::BusSettings& settings) {
  const auto t3_5 = modbus::RtuTiming(settings.line.baud, settings.line.format).t3_5();
  if (settings.frame_gap && *settings.frame_gap < t3_5) {
    table.warning("frame_gap", to_text(*settings.frame_gap) + " is shorter than t3.5, " +
                                   to_text(t3_5) + " at " +
                                   std::to_string(static_cast<std::uint32_t>(settings.line.baud)) +
                                   " baud: only for devices that allow it");
  }
}

/// Two buses on one line would talk into each other's transactions.
void check_line(Draft& draft, const bus::BusSettings& settings) {
  const auto& all = draft.settings.buses;
  const auto& path = settings.line.device;
  const auto same = std::ranges::find(all, path, [](const auto& bus) { return bus.line.device; });
  if (!path.empty() && same != all.end()) {
    report_twice(draft.buses, static_cast<std::size_t>(same - all.begin()), "device", path);
  }
}

}  // namespace

void read_buses(Draft& draft) {
  for (auto table : draft.document.root().tables("bus")) {
    bus::BusSettings settings;
    draft.buses.push_back(table);
    settings.name = read_name(table);
    check_name(draft.buses, draft.settings.buses, settings.name);
    read_line(table, settings.line);
    check_line(draft, settings);
    read_times(table, settings);
    check_frame_gap(table, settings);
    assign(settings.queue, table.integer("queue", {1, 1'000'000}));
    draft.settings.buses.push_back(std::move(settings));
  }
}

}  // namespace mbgate::config
