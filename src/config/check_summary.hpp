// SPDX-License-Identifier: Apache-2.0
// What is said of a configuration in which nothing is wrong.
#pragma once

#include <string>
#include <vector>

#include "gateway/settings.hpp"

namespace mbgate::config {

/// "configuration ok: 2 listeners, 1 bus, 3 devices, 2 routes", and a line for each of its needs.
/// `settings`: as they were read.
std::string check_summary(const gateway::Settings& settings);

// What a configuration needs of the service beyond what every one does. It is read off the
// settings; nothing is tried.

/// "needs port 502 (listener "plant"): mbgated.socket, or the drop-in port-502.conf". None for a
/// configuration without needs.
std::vector<std::string> needs(const gateway::Settings& settings);

}  // namespace mbgate::config
