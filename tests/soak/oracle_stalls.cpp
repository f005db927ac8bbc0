// SPDX-License-Identifier: Apache-2.0
// What a client writes while the gateway does not read it: by choice, or because the process did
// not run for a while and knows it.
#include <algorithm>

#include "soak/oracle.hpp"
#include "soak/withdrawals.hpp"

namespace mbgate::soak {

void Oracle::paused(ClientId client) {
  const auto entry = sessions_.find(client);
  if (entry == sessions_.end() || entry->second.paused_since) {
    return;
  }
  entry->second.paused_since = schedule_.now();
  for (const auto& [transaction, id] : entry->second.by_transaction) {
    Asked& asked = *open_.at(id);
    if (!asked.has_begun && !asked.waits_in_pause) {
      asked.waits_in_pause = true;
      asked.written = std::max(asked.written, schedule_.now());
    }
  }
}

void Oracle::seen_empty(ClientId client, Instant at) {
  if (const auto entry = sessions_.find(client); entry != sessions_.end()) {
    entry->second.paused_since.reset();
    entry->second.read_empty = std::max(entry->second.read_empty, at);
  }
}

// What lies in a socket then may have come at any time since, but not before the socket was seen
// empty, or its connection came: it is as old as that. What comes until it is seen empty again may
// count as old, too; a part may still be with the client.
void Oracle::stalled(Instant since) {
  for (auto& [client, session] : sessions_) {
    if (session.paused_since) {
      continue;
    }
    const Instant from = session.has_tls ? since : std::max(since, session.read_empty);
    session.paused_since = from;
    for (const auto& [transaction, id] : session.by_transaction) {
      Asked& asked = *open_.at(id);
      if (!asked.has_begun && !asked.waits_in_pause) {
        asked.earliest = std::min(asked.earliest, from);
        if (asked.written <= schedule_.now()) {
          asked.waits_in_pause = true;
          // A reload may have come meanwhile, before the process stopped. What then meant
          // something else is no stop any more, and takes no place ahead of others.
          Withdrawals(*this).refuse_outdated(asked, from);
          asked.written = std::max(since, session.read_empty);
        }
      }
    }
  }
}

}  // namespace mbgate::soak
