// SPDX-License-Identifier: Apache-2.0
// What settings need and this process may not do: ports, network sockets, the place of the control
// socket. Trying again does not help, so a configuration with such a need is refused. Serial ports
// are not looked at: an adapter may come later, and its line says by itself what is missing.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "gateway/settings.hpp"
#include "io/denials/attempts.hpp"
#include "io/denials/starter.hpp"

namespace mbgate::io {

/// One line for each: the key, what the system said, and what helps. `from_systemd`: the names of
/// the sockets that systemd has handed over, which take the place of a listener's own.
std::vector<std::string> denials(const gateway::Settings& settings,
                                 const std::set<std::string>& from_systemd,
                                 const Attempts& attempts = {}, Starter starter = io::starter());

}  // namespace mbgate::io
