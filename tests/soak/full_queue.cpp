// SPDX-License-Identifier: Apache-2.0
#include "soak/full_queue.hpp"

#include <algorithm>

namespace mbgate::soak {
namespace {

/// What waits of one client address.
struct Waiting {
  std::size_t surely = 0;
  std::size_t at_most = 0;
};

bool surely_waits(const Asked& asked, const Piece& piece, Instant now) {
  return piece.counted && !asked.maybe_on_wire && !asked.dropped && !asked.doomed &&
         !piece.taken_back && !asked.client_gone && asked.accepted < now &&
         now < asked.deadline - (asked.written - asked.earliest);
}

std::map<unsigned, Waiting> waiting_on(const Book& book, std::size_t bus, Instant now) {
  std::map<unsigned, Waiting> hosts;
  for (const Lane& lane : book.lanes) {
    for (const Asked* asked : lane.open) {
      const Piece& piece = asked->pieces.front();
      Waiting& waiting = hosts[asked->host];
      waiting.at_most += asked->is_stop() ? 0U : 1U;  // of several parts more often than it waits
      if (asked->kind != Kind::broadcast && piece.bus == bus && surely_waits(*asked, piece, now)) {
        ++waiting.surely;
      }
    }
  }
  return hosts;
}

// Each may have taken one back, which is told after this.
std::size_t came_since(const Book& book, Instant since) {
  std::size_t count = 0;
  for (const Lane& lane : book.lanes) {
    count += static_cast<std::size_t>(
        std::ranges::count_if(lane.open, [&](const Asked* it) { return it->accepted >= since; }));
  }
  return count;
}

}  // namespace

bool had_another_more(const Book& book, std::size_t bus, const Asked& evicted, std::size_t taken,
                      Duration lateness, Instant now) {
  const auto hosts = waiting_on(book, bus, now);
  const auto own = hosts.find(evicted.host);
  const std::size_t spared = taken + came_since(book, now - lateness);
  return own != hosts.end() && std::ranges::any_of(hosts, [&](const auto& other) {
           return other.second.surely > own->second.at_most + spared;
         });
}

}  // namespace mbgate::soak
