// SPDX-License-Identifier: Apache-2.0
// What the kernel is told of a connection that carries a line: how soon it gives it up.
#pragma once

#include <string>
#include <vector>

#include "bus/settings.hpp"

namespace mbgate::io {

/// What could not be set, a line for each that begins with the `name` of the far end.
std::vector<std::string> set_options(int socket, const bus::ConnectionTimes& times,
                                     const std::string& name);

}  // namespace mbgate::io
