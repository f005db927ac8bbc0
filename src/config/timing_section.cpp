// SPDX-License-Identifier: Apache-2.0
// Times that a bus states for its devices, and a device for itself.
#include <array>

#include "config/duration_text.hpp"
#include "config/sections.hpp"

namespace mbgate::config {
namespace {

using namespace std::chrono_literals;

constexpr std::array kQuarantineKeys = {"quarantine", "quarantine_max"};

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
  for (const auto* key : {"quarantine_max", "quarantine", "response_timeout"}) {
    if (table.has(key)) {  // otherwise the bus has been told already
      table.error(key, "quarantine_max (" + to_text(timing.quarantine_max) +
                           ") is shorter than quarantine (" + to_text(first) +
                           (timing.quarantine ? ")" : ", one more response timeout)"));
      return;
    }
  }
}

void read_quarantine(TomlTable& table, TimingOrigin origin, drive::DeviceTiming& timing) {
  if (origin.tcp) {
    for (const auto* key : kQuarantineKeys) {
      if (table.has(key)) {
        table.error(key,
                    "belongs to serial lines: the late responses of a Modbus TCP server are known "
                    "by their transaction identifiers");
      }
    }
    return;
  }
  assign(timing.quarantine, table.duration("quarantine", {0s, 1h}));
  assign(timing.quarantine_max, table.duration("quarantine_max", {0s, 1h}));
  if (table.has("quarantine") && timing.quarantine == 0s) {
    table.warning("quarantine",
                  "without one, a late response can be taken for the answer to the next request");
  }
  check_longest_quarantine(table, origin.longest_quarantine, timing);
}

/// An offline device would be waited for longer than one that answers.
void check_probe_timeout(TomlTable& table, const drive::DeviceTiming& timing) {
  if (!timing.probe_timeout || *timing.probe_timeout <= timing.response_timeout) {
    return;
  }
  for (const auto* key : {"probe_timeout", "response_timeout"}) {
    if (table.has(key)) {  // otherwise the bus has been told already
      table.warning(key, "probe_timeout (" + to_text(*timing.probe_timeout) +
                             ") is longer than response_timeout (" +
                             to_text(timing.response_timeout) +
                             "): an offline device is waited for longer than one that answers");
      return;
    }
  }
}

}  // namespace

void read_shared_timing(TomlTable& table, TimingOrigin origin, drive::DeviceTiming& timing) {
  assign(timing.response_timeout, table.duration("response_timeout", {1ms, 1h}));
  assign(timing.retries, table.integer("retries", {0, 100}));
  assign(timing.stop_retries, table.integer("stop_retries", {0, 100}));
  read_quarantine(table, origin, timing);
  assign(timing.offline_after, table.integer("offline_after", {0, 1000}));
  assign(timing.probe_interval, table.duration("probe_interval", {1ms, 1h}));
  assign(timing.probe_timeout, table.duration("probe_timeout", {1ms, 1h}));
  check_probe_timeout(table, timing);
}

}  // namespace mbgate::config
