// SPDX-License-Identifier: Apache-2.0
// Looks at a serial port from outside, as the system shows it: nothing is opened.
#pragma once

#include <string>
#include <vector>

#include "ctl/doctor/port_findings.hpp"

namespace mbgate::ctl {

PortFacts look_at_port(const std::string& device);
PermissionFacts look_at_permission(const std::string& device);
/// Who has locked the port: that one process, which anybody may see. Else those of find_holders().
std::vector<Holder> find_lock_holders(const std::string& device);
/// The other processes that have the port open, as far as we may see them: without root only those
/// of our own user.
std::vector<Holder> find_holders(const std::string& device);
/// `low_latency` of the facts is not set.
LatencyFacts look_at_latency(const std::string& device);
/// What is at the other end of a pseudo-terminal is a program, which has both ends open.
[[nodiscard]] bool is_pseudo_terminal(const std::string& device);

}  // namespace mbgate::ctl
