// SPDX-License-Identifier: Apache-2.0
// Carries `mbgatectl profile` out: no gateway is asked, the files are read.
#pragma once

#include <iosfwd>

#include "ctl/request/command.hpp"

namespace mbgate::ctl {

/// The profile, or the list of all, goes to `out`; what is wrong to `errors`. Returns the exit
/// status.
int show_profile(const ProfileCommand& command, std::ostream& out, std::ostream& errors);

}  // namespace mbgate::ctl
