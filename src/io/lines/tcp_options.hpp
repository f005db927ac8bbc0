// SPDX-License-Identifier: Apache-2.0
// Socket options of a connection that carries a line: how soon the kernel gives it up.
#pragma once

#include <string>
#include <vector>

#include "bus/settings.hpp"

namespace mbgate::io {

/// Sets them. Returns a line of text for each that could not be set; it begins with `name`, the
/// name of the server.
std::vector<std::string> set_options(int socket, const bus::ConnectionTimes& times,
                                     const std::string& name);

}  // namespace mbgate::io
