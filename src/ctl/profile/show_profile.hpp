// SPDX-License-Identifier: Apache-2.0
// Runs `mbgatectl profile`: reads the files; no gateway is contacted.
#pragma once

#include <iosfwd>

#include "ctl/request/command.hpp"

namespace mbgate::ctl {

/// Prints the profile, or the list of all, to `out`, and errors to `errors`. Returns the exit
/// status.
int show_profile(const ProfileCommand& command, std::ostream& out, std::ostream& errors);

}  // namespace mbgate::ctl
