// SPDX-License-Identifier: Apache-2.0
// Finds out at which rate and parity the units of a serial line answer. It has no port and no
// clock: the line sets a mode, and asks a unit.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "ctl/request/command.hpp"
#include "ctl/serial/heard.hpp"
#include "ctl/serial/serial_port.hpp"

namespace mbgate::ctl {

struct SweepPlan {
  PortSweep port;  ///< with at least one mode
  std::vector<std::uint8_t> units;
};

/// What was learned in one mode.
struct ModeFindings {
  LineMode mode;
  std::vector<std::uint8_t> units{};     ///< those that answered, in ascending order
  std::vector<std::uint8_t> others{};    ///< whose frames came late, or were not asked for
  std::size_t bad_crcs = 0;              ///< frames that began as the answer does
  std::size_t noise = 0;                 ///< how often there were bytes that are no frame
  std::size_t noise_bytes = 0;           ///< of both
  std::optional<std::string> refusal{};  ///< why the port cannot have this mode
};

/// What each unit is asked: nearly every one answers this, if only with an exception.
inline constexpr modbus::TableRange kSweepRead{modbus::Table::holding_registers, 0, 1};

/// The line that is swept.
struct SweptLine {
  /// Why the port cannot have the mode, or nothing.
  std::function<std::optional<std::string>(const LineMode&)> set_mode;
  /// Reads kSweepRead. The error ends the sweep.
  std::function<Result<Heard, std::string>(std::uint8_t unit)> ask;
  /// Called before each question: "9600 8N1 (2 of 15): asking unit 7, 0 found".
  std::function<void(const std::string&)> progress;
};

class Sweep {
 public:
  explicit Sweep(SweepPlan plan);

  /// Asks all that is worth asking; the error is that of the line.
  std::optional<std::string> run(const SweptLine& line);

  [[nodiscard]] const SweepPlan& plan() const { return plan_; }
  /// Of the modes so far, in their order.
  [[nodiscard]] const std::vector<ModeFindings>& findings() const { return findings_; }
  /// The mode in which most units answered, the first of equals; nullptr if none answered.
  [[nodiscard]] const ModeFindings* best() const;

 private:
  std::optional<std::string> ask_all(ModeFindings& found, const SweptLine& line);

  SweepPlan plan_;
  std::vector<ModeFindings> findings_;  ///< the last one may be that of the mode in work
};

/// How long the sweep takes where nobody answers, and no longer where somebody does; only a line
/// full of noise takes more.
std::chrono::nanoseconds longest(const SweepPlan& plan);

/// "asking 32 units at /dev/ttyUSB0 in 15 modes, 9600 8E1 first: 58s at most, and some seconds for
/// each that answers; only reads are sent"
std::string sweep_announcement(const SweepPlan& plan);

/// What was heard beside answers, what was not tried, and other modes with answers: a sentence
/// each.
std::vector<std::string> sweep_notes(const Sweep& sweep);

/// "no unit answered at /dev/ttyUSB0 in 15 modes": where nobody did.
std::string nobody_text(const Sweep& sweep);

/// "unit 3" or "units 1-3, 7", of units in ascending order.
std::string units_text(const std::vector<std::uint8_t>& units);

}  // namespace mbgate::ctl
