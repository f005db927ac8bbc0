// SPDX-License-Identifier: Apache-2.0
// What the connections of one client address to one listener may do together: how many there are,
// how many come within a second, how many requests they send within one. Without these a single
// computer could take all places of a listener, and all of the processor.
//
// A connection too many is refused. A request too many is neither refused nor lost: it is not taken
// until it is its turn, and the socket is read no further than the read-ahead, as with a full
// pipeline. TCP then slows the client down, and every request still gets its answer. Stops are
// taken out of the read-ahead at once.
#pragma once

#include <deque>
#include <map>
#include <utility>
#include <vector>

#include "gateway/clients/client_session.hpp"
#include "gateway/second_rate.hpp"

namespace mbgate::gateway {

class AddressLimits {
 public:
  /// Has the address as many connections to the listener as it may have?
  [[nodiscard]] bool is_full(const ClientInfo& info, const ListenerSettings& listener) const;
  /// Have as many come from there lately as may?
  [[nodiscard]] bool comes_too_often(const ClientInfo& info, const ListenerSettings& listener,
                                     Instant now) const;
  /// A connection was let in, or is gone.
  void came(const ClientSession& session, Instant now);
  void left(const ClientSession& session);

  /// May the next request of the client be taken? If not, its turn is at `session.held_until`. The
  /// connections of an address take turns. What a stop waits for is never held up.
  bool may_ask(ClientSession& session, Instant now);
  /// It has taken a request.
  void use_turn(ClientSession& session);
  /// It has no request that its turn could be for. Returns whose turn comes earlier now.
  std::vector<ClientSession*> give_back(ClientSession& session, Instant now);
  /// To be told to the operator now, that requests of this address are held up? Once a minute.
  bool is_news(const ClientSession& session, Instant now);

 private:
  using Key = std::pair<ListenerId, ClientKey>;
  struct Waiting {
    ClientSession* session;
    Instant turn;
    unsigned per_second;  ///< it was taken by that limit
  };
  struct Entry {
    std::size_t connections = 0;
    SecondRate connects;
    SecondRate requests;
    std::vector<Waiting> line;  ///< in the order of their turns
    std::optional<Instant> told_at;
  };
  static Key place_of(const ClientInfo& info, const ListenerSettings& listener) {
    return {info.listener, key_of(info, listener)};
  }
  static Key place_of(const ClientSession& session) {
    return {session.info().listener, session.key()};
  }
  void forget(Instant now);

  std::map<Key, Entry> entries_;
  /// Addresses without a connection, whose rates are still remembered: no more than can come within
  /// a second or two.
  std::deque<std::pair<Instant, Key>> leaving_;
};

}  // namespace mbgate::gateway
