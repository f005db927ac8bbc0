// SPDX-License-Identifier: Apache-2.0
// Shared by the diagnoses of lines and of devices: facts about all devices of a bus together, and
// figures as text.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "report/findings/diagnosis.hpp"

namespace mbgate::report {

using gateway::BusStatus;
using gateway::DeviceStatus;
using gateway::Duration;
using gateway::StatusReport;

/// "19200 baud 8E1"
std::string mode_text(const BusStatus& bus);
/// "12 ms": milliseconds begun.
std::string milliseconds_text(bus::Duration duration);

/// An RTU or ASCII line behind a serial device server: what the gateway connects to is no Modbus
/// TCP server, and has the rate and the parity.
[[nodiscard]] bool is_behind_a_server(const BusStatus& bus);

std::string subject_of(const BusStatus& bus);
std::string subject_of(const StatusReport& report, const DeviceStatus& device);

/// May that be why no device seems to answer?
[[nodiscard]] constexpr bool hides_answers(bus::NoticedEcho echo) {
  return echo == bus::NoticedEcho::denied || echo == bus::NoticedEcho::unproven;
}

/// Did it happen in the last ten minutes? What happened earlier is no longer reported.
[[nodiscard]] bool is_lately(const std::optional<Duration>& ago);

/// Do bytes come from it, whatever they are? Bad CRCs of earlier say nothing of a device that is
/// silent now.
[[nodiscard]] bool speaks(const DeviceStatus& device);
/// Does somebody ask it still? Of an address without a device that is forgotten sooner.
[[nodiscard]] bool is_asked(const DeviceStatus& device);
/// Is there one, or should there be? An address that nobody names and that has never answered may
/// be a client's mistake.
[[nodiscard]] bool is_drive(const DeviceStatus& device);
/// Has another device of its bus answered since the first request that this one left unanswered?
[[nodiscard]] bool do_others_answer(const StatusReport& report, const DeviceStatus& device);

/// Is there something to find in the quality of answers? Not if all is well, or nothing is known.
[[nodiscard]] bool is_bad(const bus::QualityVerdict& verdict);
/// Of a verdict that is_bad(). The caller adds the subject.
[[nodiscard]] Diagnosis quality_finding(const bus::QualityVerdict& verdict, bool is_of_line);
/// The same as one sentence, for the journal.
std::string quality_text(const bus::QualityNotice& notice);

/// What the devices of a bus have in common.
struct Together {
  std::uint64_t silent = 0;  ///< devices; addresses that are no drives only where no drive is asked
  std::uint64_t unreached = 0;   ///< of these, those that a server says that it did not reach
  std::uint64_t unanswered = 0;  ///< transmissions in a row, of all of them
  Duration silent_for{0};        ///< how long ago the first of these was sent
  bool does_one_speak = false;   ///< since the last of the silent ones fell silent
  bool had_answers = false;      ///< from any device, ever
  bool has_names = false;        ///< the configuration has devices on it
  bool are_waited_for = false;   ///< response timeouts of some take the time of the line

  /// Not one alone that has answered before: that is told of the device.
  [[nodiscard]] bool is_dead() const {
    return silent > 0 && !does_one_speak && (silent > 1 || !had_answers);
  }
};
/// `bus`: its place in the report.
Together together(const StatusReport& report, std::size_t bus);

/// Adds what is wrong with the bus.
void diagnose_bus(const BusStatus& bus, const Together& all, std::vector<Diagnosis>& found);

}  // namespace mbgate::report
