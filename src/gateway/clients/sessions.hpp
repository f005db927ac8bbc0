// SPDX-License-Identifier: Apache-2.0
// The connections of clients: how many each listener has, whose turns they share, and when one must
// be looked at next. One that is closed is only marked, so that whoever works with it may go on; it
// is forgotten by sweep().
#pragma once

#include <map>
#include <optional>
#include <unordered_map>
#include <vector>

#include "bus/state_reader.hpp"
#include "gateway/client.hpp"
#include "gateway/clients/client_session.hpp"
#include "gateway/clients/client_timers.hpp"

namespace mbgate::gateway {

class Sessions {
 public:
  explicit Sessions(const Settings& settings)
      : settings_(&settings), on_listener_(settings.listeners.size()) {}

  [[nodiscard]] bool is_full(ListenerId listener) const;
  /// The one that was idle for longest of those that may make room on the listener; or nothing.
  [[nodiscard]] ClientSession* idlest(ListenerId listener);
  /// Nothing if there is one of this number.
  ClientSession* add(ClientId client, const ClientInfo& info, Instant now);
  /// Nothing if it is closed, or never was there.
  [[nodiscard]] ClientSession* find(ClientId client);
  void close(ClientSession& session);
  /// Forgets those that were closed. To be called when nobody works with one.
  void sweep();
  /// That are open.
  [[nodiscard]] std::size_t size() const { return sessions_.size() - closed_.size(); }
  template <typename Visit>
  void for_each(Visit visit);
  template <typename Visit>
  void for_each(Visit visit) const;

  /// Something may be done for the client.
  void wake(const ClientSession& session) { ready_.push_back(session.id()); }
  /// The last one that was woken and is still open, or nothing.
  ClientSession* take_ready();
  [[nodiscard]] bool any_ready() const { return !ready_.empty(); }

  /// The client is to be looked at then, if not before.
  void look_at(ClientSession& session, std::optional<Instant> at);
  [[nodiscard]] std::optional<Instant> next_look() const { return timers_.next(); }
  /// A client whose time has come, or nothing.
  ClientSession* take_due(Instant now);

  /// Connections from one address share its turns. Those of an address without any are the
  /// gateway's.
  [[nodiscard]] Turns turns_of(const routing::ClientAddress& address) const;

  /// Other settings, in which the listeners of all clients are there.
  void adopt(const Settings& next, Instant now);

 private:
  friend struct mbgate::StateReader;
  struct Address {
    bus::FairnessKey key;
    std::size_t connections;
    unsigned weight;
  };
  [[nodiscard]] std::size_t& on(ListenerId listener) {
    return on_listener_[static_cast<std::size_t>(listener)];
  }
  void add_connection(const routing::ClientAddress& address);
  [[nodiscard]] unsigned weight_of(const routing::ClientAddress& address) const;

  const Settings* settings_;
  std::unordered_map<ClientId, ClientSession> sessions_;
  std::vector<ClientId> closed_;
  std::vector<ClientId> ready_;
  ClientTimers timers_;
  std::vector<std::size_t> on_listener_;
  std::map<routing::ClientAddress, Address> addresses_;
  std::vector<bus::FairnessKey> free_keys_;
};

template <typename Visit>
void Sessions::for_each(Visit visit) {
  for (auto& [client, session] : sessions_) {
    if (!session.is_closed) {
      visit(session);
    }
  }
}

template <typename Visit>
void Sessions::for_each(Visit visit) const {
  for (const auto& [client, session] : sessions_) {
    if (!session.is_closed) {
      visit(session);
    }
  }
}

}  // namespace mbgate::gateway
