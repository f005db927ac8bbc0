// SPDX-License-Identifier: Apache-2.0
// What a configuration needs from the system beyond the service as it is shipped, such as a port
// below 1024. Derived from the settings; nothing is tried.
#pragma once

#include <string>
#include <vector>

#include "gateway/settings.hpp"

namespace mbgate::config {

/// "needs port 502 (listener "plant"): mbgated.socket, or the drop-in port-502.conf". None for a
/// configuration without needs.
std::vector<std::string> needs(const gateway::Settings& settings);

}  // namespace mbgate::config
