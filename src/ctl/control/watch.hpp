// SPDX-License-Identifier: Apache-2.0
// `mbgatectl status --watch`: the status again and again, on a screen or as blocks of text.
#pragma once

#include <iosfwd>

#include "ctl/request/command.hpp"

namespace mbgate::ctl {

/// Asks every `command.every` until `command.times` is reached, a signal comes, or "q" is typed on
/// the screen. Where mbgated does not answer, it is asked again. Returns the exit status: kExitDone
/// if interrupted, or if every question was answered.
int watch_status(const StatusCommand& command, std::ostream& out, std::ostream& errors);

}  // namespace mbgate::ctl
