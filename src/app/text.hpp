// SPDX-License-Identifier: Apache-2.0
// The lines that mbgated prints or hands to systemd, apart from the log.
#pragma once

#include <string>

#include "gateway/gateway.hpp"

namespace mbgate::app {

/// "configuration ok: 2 listeners, 1 bus, 3 devices, 2 routes"
std::string check_summary(const gateway::Settings& settings);

/// "2 listeners, 1 of 2 buses open, 3 clients"; "1 of 2 listeners, ..." while one waits for its
/// address.
std::string status_text(const gateway::Settings& settings, const gateway::Status& status,
                        std::size_t listeners_waiting);

}  // namespace mbgate::app
