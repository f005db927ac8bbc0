// SPDX-License-Identifier: Apache-2.0
// Advice for errors in which the system refuses something to this process. Each text begins with ";
// ", to follow the error text of the system, or is empty if the cause is not certain.
#pragma once

#include <cstdint>
#include <string>

namespace mbgate::io {

/// Is it a denial (EACCES, EPERM, EAFNOSUPPORT), which lasts until somebody permits what was tried?
bool is_denial(int error);
/// A socket for this port could not be made or bound.
std::string listen_advice(std::uint16_t port, int error);
/// A connection to another machine could not be made.
std::string connect_advice(int error);
/// A file or socket could not be made in this folder. `instead`: what the service may do.
std::string folder_advice(const std::string& folder, int error, const std::string& instead);

}  // namespace mbgate::io
