// SPDX-License-Identifier: Apache-2.0
// The summary that --check prints for a configuration without errors.
#pragma once

#include <string>
#include <vector>

#include "gateway/settings.hpp"

namespace mbgate::config {

/// "configuration ok: 2 listeners, 1 bus, 3 devices, 2 routes", and a line for each of its needs.
/// `settings`: as they were read.
std::string check_summary(const gateway::Settings& settings);

// What a configuration needs from the system beyond the service as it is shipped, such as a port
// below 1024. Derived from the settings; nothing is tried.

/// "needs port 502 (listener "plant"): mbgated.socket, or the drop-in port-502.conf". None for a
/// configuration without needs.
std::vector<std::string> needs(const gateway::Settings& settings);

}  // namespace mbgate::config
