// SPDX-License-Identifier: Apache-2.0
// What is said of a sweep: before it, while it runs, and after it.
#pragma once

#include <string>
#include <vector>

#include "ctl/scan/sweep.hpp"

namespace mbgate::ctl {

/// "asking 32 units at /dev/ttyUSB0 in 15 modes, 9600 8E1 first: 58s at most; only reads are sent"
std::string sweep_announcement(const std::string& device, const SweepPlan& plan);

/// "9600 8N1 (2 of 15): asking unit 7, 0 found", of the next step.
std::string sweep_progress(const Sweep& sweep);

/// What was heard beside answers, what was not tried, and other modes with answers: a sentence
/// each.
std::vector<std::string> sweep_notes(const Sweep& sweep);

/// "no unit answered at /dev/ttyUSB0 in 15 modes": where nobody did.
std::string nobody_text(const std::string& device, const Sweep& sweep);

/// "unit 3" or "units 1-3, 7", of units in ascending order.
std::string units_text(const std::vector<std::uint8_t>& units);

}  // namespace mbgate::ctl
