// SPDX-License-Identifier: Apache-2.0
// One question to a running mbgated, how it is, and the answer as it is printed.
#pragma once

#include <functional>
#include <string>

#include "ctl/request/command.hpp"
#include "ctl/request/report.hpp"

namespace mbgate::ctl {

using StatusAnswer = Result<std::string, Failure>;

/// Text for people, or with --json one object on one line. It ends with a newline; a failure is a
/// sentence. `give_up`: as of ask_control().
StatusAnswer ask_status(const StatusCommand& command, const std::function<bool()>& give_up = {});

}  // namespace mbgate::ctl
