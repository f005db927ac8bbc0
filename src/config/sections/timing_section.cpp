// SPDX-License-Identifier: Apache-2.0
// Times that a bus states for its devices, and a device for itself.
#include "config/sections/sections.hpp"
#include "config/toml/duration_text.hpp"

namespace mbgate::config {
namespace {

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
  for (const auto* key : {"quarantine_max", "quarantine", "response_timeout"}) {
    if (table.has(key)) {  // otherwise the error was reported at the bus
      table.error(key, "quarantine_max (" + to_text(timing.quarantine_max) +
                           ") is shorter than quarantine (" + to_text(first) +
                           (timing.quarantine ? ")" : ", one more response timeout)"));
      return;
    }
  }
}

void check_quarantine(TomlTable& table, TimingOrigin origin, drive::DeviceTiming& timing) {
  if (origin.lines == Lines::server) {
    return;  // it has none
  }
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
  read_keys(table, timing_keys(), timing, origin.lines);
  check_quarantine(table, origin, timing);
  check_probe_timeout(table, timing);
}

}  // namespace mbgate::config
