// SPDX-License-Identifier: Apache-2.0
// What systemd hands to the process and what the process reports to it. Without systemd all of this
// does nothing.
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
/// A reload has begun; notify_ready() reports its end.
void notify_reloading();

}  // namespace mbgate::app
