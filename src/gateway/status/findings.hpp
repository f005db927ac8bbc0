// SPDX-License-Identifier: Apache-2.0
// What the diagnoses of lines and of devices have in common: what is known of the devices of a bus
// together, and figures as text.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "gateway/status/diagnosis.hpp"

namespace mbgate::gateway {

/// "1 request", "2 requests".
std::string counted(std::uint64_t count, const char* one);
/// Whole seconds that are over: "5 s".
std::string seconds_text(Duration duration);
/// "19200 baud 8E1"
std::string mode_text(const BusStatus& bus);

std::string subject_of(const BusStatus& bus);
std::string subject_of(const StatusReport& report, const DeviceStatus& device);

/// Did it happen in the last ten minutes? What was noticed once is no matter of today.
[[nodiscard]] bool is_lately(const std::optional<Duration>& ago);

/// Do bytes come from it, whatever they are? Bad CRCs of earlier say nothing of a device that is
/// silent now.
[[nodiscard]] bool speaks(const DeviceStatus& device);
/// Addresses without a device count only as long as somebody asks them.
[[nodiscard]] bool is_asked(const DeviceStatus& device);

/// Of a verdict that is_bad().
Diagnosis diagnosis_of_quality(std::string subject, const bus::QualityVerdict& verdict,
                               bool is_of_line);

/// What the devices of a bus have in common.
struct Together {
  std::uint64_t asked = 0;  ///< devices
  std::uint64_t silent = 0;
  std::uint64_t unanswered = 0;  ///< transmissions in a row, of all of them
  bool had_answers = false;
  bool are_waited_for = false;            ///< response timeouts of some take the time of the line
  std::optional<Duration> shortest_wait;  ///< the median of each answering device, the least of it

  /// Not one alone that has answered before: that is told of the device.
  [[nodiscard]] bool is_dead() const {
    return silent > 0 && silent == asked && (asked > 1 || !had_answers);
  }
};
/// `bus`: its place in the report.
Together together(const StatusReport& report, std::size_t bus);

/// Adds what is wrong with the bus.
void diagnose_bus(const StatusReport& report, const BusStatus& bus, const Together& all,
                  std::vector<Diagnosis>& found);

}  // namespace mbgate::gateway
