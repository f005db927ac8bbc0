// SPDX-License-Identifier: Apache-2.0
// What --check prints for a configuration without errors.
#pragma once

#include <string>

#include "gateway/settings.hpp"

namespace mbgate::config {

/// "configuration ok: 2 listeners, 1 bus, 3 devices, 2 routes", and a line for each of its needs.
/// `settings`: as they were read.
std::string check_summary(const gateway::Settings& settings);

}  // namespace mbgate::config
