// SPDX-License-Identifier: Apache-2.0
#include "gateway/clients/room.hpp"

#include <algorithm>
#include <map>
#include <tuple>
#include <vector>

namespace mbgate::gateway {
namespace {

// Who never asked, then who has nothing to do, for longest; then who connected first.
bool goes_before(const ClientSession* one, const ClientSession* other) {
  const auto place = [](const ClientSession& it) {
    return std::tuple(it.has_asked, !it.is_at_rest(),
                      it.is_at_rest() ? it.last_activity : Instant::min(), it.id());
  };
  return place(*one) < place(*other);
}

ClientSession* first_to_go(const std::vector<ClientSession*>& candidates) {
  const auto first = std::ranges::min_element(candidates, goes_before);
  return first == candidates.end() ? nullptr : *first;
}

std::vector<ClientSession*> displaceable(Sessions& sessions, ListenerId listener) {
  std::vector<ClientSession*> all;
  sessions.for_each([&](ClientSession& session) {
    if (session.info().listener == listener &&
        !session.listener().keep.contains(session.info().address, session.info().role)) {
      all.push_back(&session);
    }
  });
  return all;
}

}  // namespace

ClientSession* to_replace(Sessions& sessions, ListenerId listener, const ClientKey& client) {
  auto own = displaceable(sessions, listener);
  std::erase_if(own,
                [&](const ClientSession* it) { return it->key() != client || !it->is_at_rest(); });
  return first_to_go(own);
}

ClientSession* to_displace(Sessions& sessions, ListenerId listener, const ClientKey& newcomer) {
  auto all = displaceable(sessions, listener);
  std::map<ClientKey, std::size_t> counts{{newcomer, 1}};
  for (const ClientSession* session : all) {
    ++counts[session->key()];
  }
  std::size_t most = 1;
  for (const auto& [client, connections] : counts) {
    most = std::max(most, connections);
  }
  const bool is_newcomer = most > 1 && counts[newcomer] == most;
  std::erase_if(all, [&](const ClientSession* it) {
    const bool is_loser = is_newcomer ? it->key() == newcomer : counts[it->key()] == most;
    return !is_loser || (most == 1 && it->has_asked);
  });
  return first_to_go(all);
}

}  // namespace mbgate::gateway
