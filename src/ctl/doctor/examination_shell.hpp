// SPDX-License-Identifier: Apache-2.0
// Examines a line step by step, and ends where going on makes no sense. Nothing is decided here
// but that.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "ctl/doctor/finding.hpp"
#include "ctl/doctor/line_plan.hpp"

namespace mbgate::ctl {

using ReportFinding = std::function<void(const Finding&)>;

/// Hands out each finding as it is made. Returns why the examination ended early, if a signal or
/// the port ended it.
std::optional<std::string> examine(const LinePlan& plan, const DoctorCommand& command,
                                   const ReportFinding& report);

}  // namespace mbgate::ctl
