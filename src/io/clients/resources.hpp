// SPDX-License-Identifier: Apache-2.0
// How much of the process clients may use: file descriptors and memory. Any number of clients may
// connect, but a replugged adapter and the process itself must still find a free
// descriptor. The kernel assigns the lowest free number, so the numbers from some limit on are
// reserved for them: a client that gets such a number is turned away.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "gateway/settings.hpp"

namespace mbgate::io {

/// Raises the soft limit to the hard limit. Returns the limit then in force. The soft limit is
/// usually 1024 because of select(2), which is not used here.
std::size_t raise_descriptor_limit();
/// The hard limit, to which raise_descriptor_limit() raises the soft one.
std::size_t hard_descriptor_limit();

struct DescriptorRoom {
  std::size_t clients = 0;  ///< connections that are possible; 0: too few descriptors to start
  /// One line, if these are fewer than the `max_connections` of all listeners together and what the
  /// HTTP interface may have.
  std::optional<std::string> shortage;
};

/// `http_sockets`: those from systemd that the HTTP interface listens at, in place of its settings.
DescriptorRoom room_for_clients(const gateway::Settings& settings, std::size_t limit,
                                std::size_t http_sockets = 0);

/// Is there memory for one more client? More must be free than the full queues of several buses
/// take: where an allocation is refused (a limit of the process, or overcommitment off), the
/// machine cannot go on with half of an input, and the process ends. Any thread may ask.
bool is_memory_left();

/// The first descriptor that no client may have, with the limit in force.
int end_of_client_descriptors(const gateway::Settings& settings);

}  // namespace mbgate::io
