// SPDX-License-Identifier: Apache-2.0
// How many file descriptors the process may have, and how many of them clients may use. Clients
// come in any number; a replugged adapter, the control socket and HTTP must find a descriptor all
// the same. The kernel gives out the lowest free number, so those from some number on are kept for
// them: a client that gets such a number is turned away.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "gateway/settings.hpp"

namespace mbgate::io {

/// Raises the limit to the hard one, which is the result. The soft limit is 1024 for the sake of
/// select(2), which nobody here uses.
std::size_t raise_descriptor_limit();
/// The limit that it would be raised to.
std::size_t hard_descriptor_limit();

struct DescriptorRoom {
  std::size_t clients = 0;  ///< connections that there can be; 0: too few descriptors to start
  /// Fewer than the listeners' max_connections together: one line about it.
  std::optional<std::string> shortage;
};

DescriptorRoom room_for_clients(const gateway::Settings& settings, std::size_t limit);

/// The first descriptor that no client may have, by the limit in force.
int end_of_client_descriptors(const gateway::Settings& settings);

}  // namespace mbgate::io
