// SPDX-License-Identifier: Apache-2.0
// The process did not run for a while, and knows it.
#include <algorithm>

#include "soak/oracle.hpp"

namespace mbgate::soak {

// What lies in a socket then may have come at any time since: it is as old as that, and so is what
// comes until the socket was seen empty.
void Oracle::stalled(Instant since) {
  for (auto& [client, session] : sessions_) {
    if (session.paused_since) {
      continue;
    }
    session.paused_since = since;
    for (const auto& [transaction, id] : session.by_transaction) {
      Asked& asked = *open_.at(id);
      if (!asked.has_begun && !asked.waits_in_pause) {
        asked.waits_in_pause = true;
        asked.earliest = std::min(asked.earliest, since);
        asked.written = std::min(asked.written, since);
      }
    }
  }
}

}  // namespace mbgate::soak
