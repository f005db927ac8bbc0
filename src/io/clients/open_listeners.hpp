// SPDX-License-Identifier: Apache-2.0
// A socket unit of systemd takes the place of a listener's address, so the configuration alone does
// not say whether other machines reach it. Drives are not opened to whole networks by a socket unit
// any more than by one line of the configuration.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "gateway/settings.hpp"

namespace mbgate::io {

/// The listening sockets that systemd has handed over.
struct SystemdSockets {
  /// Where other machines reach a socket of that name, such as "[::]:502".
  std::map<std::string, std::string> reached;

  /// `socket`: its descriptor, which stays the caller's.
  void add(const std::string& name, int socket);
  /// They are closed: a listener of that name has its own address from now on.
  void drop(const std::string& name);
};

/// One line for each listener that lets everyone in there: neither `allow` nor a rule says who may
/// connect. Such a configuration is refused, as with an address that other machines reach.
std::vector<std::string> open_listeners(const gateway::Settings& settings,
                                        const SystemdSockets& sockets);

}  // namespace mbgate::io
