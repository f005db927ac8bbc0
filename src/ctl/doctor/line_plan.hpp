// SPDX-License-Identifier: Apache-2.0
// The line to examine, its known settings, and the units to ask.
//
// To change what `mbgatectl doctor` finds, and what it says
// - the order of its steps, and how they are printed: examination_shell.
// - the port: findings, port_facts_shell; the idle line: line_findings.
// - the units that it asks, its waits, its end: questions_shell.
// - bytes after a request, and between two requests: trial.
// - echo, other clients, answers, two devices at one address: line_findings, answer_findings.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "config/load.hpp"
#include "ctl/request/command.hpp"

namespace mbgate::ctl {

struct PlannedUnit {
  std::uint8_t address = 1;
  std::string name{};                         ///< of the configuration; may be empty
  std::chrono::nanoseconds timeout;           ///< later answers are too late for the gateway
  std::chrono::nanoseconds pause{0};          ///< before each request, beyond t3.5
  std::chrono::nanoseconds response_wait{0};  ///< part of the timeout, a key of its own
};

/// "unit 3", "unit 3 (axis-x)"
std::string unit_text(const PlannedUnit& unit);

struct LinePlan {
  std::string device;
  LineMode mode;
  std::vector<PlannedUnit> units{};
  std::optional<std::string> nobody{};  ///< why no unit is asked
  std::optional<bool> echo{};           ///< what the configuration says
  std::optional<bool> low_latency{};    ///< none: there is no configuration
  /// The adapter keeps bytes back so long here, but not from the gateway.
  std::chrono::nanoseconds adapter_delay{0};
};

/// Of a port that no configuration describes; `command` has one.
LinePlan plan_of_port(const DoctorCommand& command);

/// Of a bus of the configuration. The error is a full sentence.
Result<LinePlan, std::string> plan_of_bus(const DoctorCommand& command,
                                          const gateway::Settings& settings);

}  // namespace mbgate::ctl
