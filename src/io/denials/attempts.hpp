// SPDX-License-Identifier: Apache-2.0
// What the system lets this process do, found by doing it and undoing it at once. Each gives 0, or
// the error of the system.
#pragma once

#include <functional>
#include <string>

#include "gateway/settings.hpp"

namespace mbgate::io {

/// A TCP socket of this family: AF_INET or AF_INET6.
int try_socket(int family);
/// The address and port of a listener, whether the machine has this address yet or not. Nobody can
/// connect meanwhile.
int try_bind(const gateway::ListenerSettings& listener);
/// A new entry in a folder. None is made.
int try_folder(const std::string& folder);

/// These, or a test's replacements for them.
struct Attempts {
  std::function<int(int family)> socket = try_socket;
  std::function<int(const gateway::ListenerSettings&)> bind = try_bind;
  std::function<int(const std::string& folder)> folder = try_folder;
};

}  // namespace mbgate::io
