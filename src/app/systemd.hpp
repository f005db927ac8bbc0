// SPDX-License-Identifier: Apache-2.0
// What systemd gives to the process and wants to hear from it. Without systemd all of this does
// nothing.
#pragma once

#include <string>
#include <vector>

#include "io/unique_fd.hpp"

namespace mbgate::app {

/// A socket of a .socket unit; `name` is its FileDescriptorName=.
struct InheritedSocket {
  std::string name;
  io::UniqueFd fd;
};

/// Takes over the sockets, once.
std::vector<InheritedSocket> take_inherited_sockets();

void notify_ready(const std::string& status);
void notify_status(const std::string& status);
void notify_stopping();
/// notify_ready() ends it.
void notify_reloading();

}  // namespace mbgate::app
