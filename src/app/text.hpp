// SPDX-License-Identifier: Apache-2.0
// The status line that `systemctl status` shows.
#pragma once

#include <string>

#include "gateway/gateway.hpp"

namespace mbgate::app {

/// "2 listeners, 1 of 2 buses open, 3 clients"; "1 of 2 listeners, ..." while one waits for its
/// address.
std::string status_text(const gateway::Settings& settings, const gateway::Status& status,
                        std::size_t listeners_waiting);

}  // namespace mbgate::app
