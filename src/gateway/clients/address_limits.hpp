// SPDX-License-Identifier: Apache-2.0
// Limits for all connections of one client address to one listener together: their number, the new
// ones within a second, and their requests within a second. Without these a single computer could
// take all places of a listener, and all of the processor.
//
// A connection too many is refused; a request too many gets 06 at once, unless it is a stop.
#pragma once

#include <map>
#include <utility>

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

  /// May the client ask something now? If so, it has. Stops need not ask.
  [[nodiscard]] bool may_ask(const ClientSession& session, Instant now);

 private:
  using Key = std::pair<ListenerId, ClientKey>;
  struct Entry {
    std::size_t connections = 0;
    SecondRate connects;
    SecondRate requests;
  };
  static Key place_of(const ClientInfo& info, const ListenerSettings& listener) {
    return {info.listener, key_of(info, listener)};
  }
  static Key place_of(const ClientSession& session) {
    return {session.info().listener, session.key()};
  }

  static constexpr std::size_t kFewAddresses = 64;
  std::map<Key, Entry> entries_;
  /// So many entries are looked through for addresses that have no connection and are rested.
  std::size_t forgets_at_ = kFewAddresses;
};

}  // namespace mbgate::gateway
