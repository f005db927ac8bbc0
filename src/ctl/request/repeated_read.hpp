// SPDX-License-Identifier: Apache-2.0
// `mbgatectl read --every`: the same read again and again.
#pragma once

#include <iosfwd>

#include "ctl/request/command.hpp"

namespace mbgate::ctl {

/// Reads every `command.every` until `command.times` is reached, or a signal comes. `request` is
/// that of the command. A read that fails is reported, and the next one done. Returns the exit
/// status: kExitDone if interrupted, or if every read was answered.
int repeat_read(const ReadCommand& command, const modbus::Request& request, std::ostream& out,
                std::ostream& errors);

}  // namespace mbgate::ctl
