// SPDX-License-Identifier: Apache-2.0
// The connections of clients: how many each listener has, which of them share turns, and when one
// must be checked next. A closed one is only marked, so that code that uses it may go on; sweep()
// removes it.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <ranges>
#include <set>
#include <unordered_map>
#include <utility>
#include <vector>

#include "bus/counters.hpp"
#include "gateway/client.hpp"
#include "gateway/clients/client_session.hpp"
#include "gateway/event.hpp"
#include "modbus/codes.hpp"

namespace mbgate::gateway {

// The counters of one listener, for all its clients together.

/// The reasons for metrics and status, by RefusalReason.
inline constexpr std::array kRefusalNames = {"not_allowed", "full",         "stopping",
                                             "no_rule",     "address_full", "too_often"};

/// Of about the last thousand requests, those to which the gateway itself answered 06, 0A or 0B.
struct RecentFailures {
  static constexpr unsigned kMost = 1000;

  void note_request() {
    if (++requests == kMost) {
      requests /= 2;
      failures /= 2;
    }
  }
  void note(std::uint8_t exception, Instant now) {
    using enum modbus::ExceptionCode;
    const auto code = static_cast<modbus::ExceptionCode>(exception);
    if (code == server_device_busy || code == gateway_path_unavailable ||
        code == gateway_target_failed_to_respond) {
      note_failed(exception, now);
    }
  }
  /// Its client has gone, has given up or has asked again before there was an answer.
  void note_unanswered(Instant now) { note_failed(0, now); }
  /// The gateway has not failed it. `answered`: nor has its client given up.
  void note_ended(bool answered, Instant now) {
    is_failing = false;
    if (!answered) {
      note_unanswered(now);
    }
  }

  unsigned requests = 0;
  unsigned failures = 0;
  std::uint8_t last = 0;  ///< its exception; 0: there was no answer
  Instant failed_at = Instant::min();
  bool is_failing = false;  ///< the last request has failed

 private:
  void note_failed(std::uint8_t exception, Instant now) {
    ++failures;
    last = exception;
    failed_at = now;
    is_failing = true;
  }
};

struct ListenerCounters {
  std::uint64_t connections = 0;  ///< let in
  /// Of these, closed to make room for others, because of max_connections and of
  /// max_connections_per_address.
  std::uint64_t displaced_full = 0;
  std::uint64_t displaced_address_full = 0;
  std::uint64_t requests = 0;
  std::uint64_t over_rate = 0;  ///< requests beyond max_requests_per_second of their client
  /// Requests that the gateway itself has answered with an exception.
  bus::ExceptionCounts refused_reads;
  bus::ExceptionCounts refused_writes;
  /// Connections that were not let in, by RefusalReason.
  std::array<std::uint64_t, kRefusalNames.size()> refused_connections{};

  RecentFailures recent;

  void note_request() {
    ++requests;
    recent.note_request();
  }
  void note_refused(bool is_read, std::uint8_t code, Instant now) {
    (is_read ? refused_reads : refused_writes).note(code);
    recent.note(code, now);
  }
  void note_displaced(RefusalReason limit) {
    ++(limit == RefusalReason::full ? displaced_full : displaced_address_full);
  }
  void note_refused(RefusalReason reason) {
    ++refused_connections.at(static_cast<std::size_t>(reason));
  }
};

class Sessions {
 public:
  explicit Sessions(const Settings& settings)
      : settings_(&settings), counters_(settings.listeners.size()) {}

  [[nodiscard]] bool is_full(ListenerId listener) const;
  /// nullptr if there is one with this number.
  ClientSession* add(ClientId client, const ClientInfo& info, Instant now);
  /// nullptr if it is closed or was never there.
  [[nodiscard]] ClientSession* find(ClientId client);
  void close(ClientSession& session);
  /// Removes those that were closed. To be called when none of them is in use, nor ready.
  void sweep();
  /// How many are open.
  [[nodiscard]] std::size_t size() const { return sessions_.size() - closed_.size(); }
  /// Those that are open: a view, to be gone through once.
  [[nodiscard]] auto open() {
    return sessions_ | std::views::values |
           std::views::filter(std::not_fn(&ClientSession::is_closed));
  }
  [[nodiscard]] auto open() const {
    return sessions_ | std::views::values |
           std::views::filter(std::not_fn(&ClientSession::is_closed));
  }
  /// The client address whose turns these are; nullptr if it has gone.
  [[nodiscard]] const routing::ClientAddress* address_of(bus::FairnessKey key) const;

  /// Something may be done for the client.
  void wake(ClientSession& session) { ready_.push_back(&session); }
  /// The last one that was woken and is still open; nullptr if there is none.
  ClientSession* take_ready();

  /// The client is to be checked at this instant, or before.
  void look_at(ClientSession& session, std::optional<Instant> at);
  [[nodiscard]] std::optional<Instant> next_look() const {
    return timers_.empty() ? std::nullopt : std::optional(timers_.begin()->first);
  }
  /// A client whose time has come; nullptr if there is none.
  ClientSession* take_due(Instant now);

  /// Connections to the listener.
  [[nodiscard]] std::size_t on(ListenerId listener) const;
  [[nodiscard]] ListenerCounters& counters(ListenerId listener) {
    return counters_[static_cast<std::size_t>(listener)];
  }
  [[nodiscard]] const ListenerCounters& counters(ListenerId listener) const {
    return counters_[static_cast<std::size_t>(listener)];
  }
  /// Of clients, and of listeners.
  void clear_counters();

  /// New settings, which still have the listeners of all clients.
  void adopt(const Settings& next, Instant now);

 private:
  struct Address {
    routing::ClientAddress first;  ///< of those that are counted as one
    Turns turns;
    std::size_t connections = 0;
  };
  const Turns& add_connection(const ClientSession& session);
  [[nodiscard]] unsigned weight_of(const routing::ClientAddress& address) const;

  const Settings* settings_;
  std::unordered_map<ClientId, ClientSession> sessions_;
  std::vector<ClientId> closed_;
  std::vector<ClientSession*> ready_;
  std::set<std::pair<Instant, ClientId>> timers_;  // one for each client that has one
  std::vector<ListenerCounters> counters_;
  std::map<ClientKey, Address> addresses_;
  std::vector<bus::FairnessKey> free_keys_;
};

/// The connection that makes room for another one of this client, because the client has as many as
/// it may; nullptr: there is none. One that waits for an answer stays.
ClientSession* to_replace(Sessions& sessions, ListenerId listener, const ClientKey& client);
/// The one that makes room because the listener is full: one of the client that has most of them,
/// the newcomer counted. Where each client has one, only one that has never asked.
ClientSession* to_displace(Sessions& sessions, ListenerId listener, const ClientKey& newcomer);

}  // namespace mbgate::gateway
