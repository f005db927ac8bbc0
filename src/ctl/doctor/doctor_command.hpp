// SPDX-License-Identifier: Apache-2.0
// Runs `mbgatectl doctor`: examines a serial line that no gateway holds.
#pragma once

#include <iosfwd>

#include "ctl/request/command.hpp"

namespace mbgate::ctl {

/// Prints a line for each step as it is done, or with --json one object at the end. Returns the
/// exit status: kExitDone if no fault was found, kExitNotDone if one was, or if it ended early.
int carry_out_doctor(const DoctorCommand& command, std::ostream& out, std::ostream& errors);

}  // namespace mbgate::ctl
