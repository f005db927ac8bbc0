// SPDX-License-Identifier: Apache-2.0
// `mbgatectl replay`: does this version do what a recorded gateway did?
#pragma once

#include <iosfwd>

#include "ctl/request/command.hpp"

namespace mbgate::ctl {

/// Prints to `out` that every action is the recorded one, or the first that is not; to `errors` why
/// the recording cannot be replayed. Returns the exit status: kExitDone, kExitNotDone for a
/// difference, kExitConfiguration for what is no recording or cannot be read.
int replay_recording(const ReplayCommand& command, std::ostream& out, std::ostream& errors);

}  // namespace mbgate::ctl
