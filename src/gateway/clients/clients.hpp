// SPDX-License-Identifier: Apache-2.0
// The client side: admits clients, handles the bytes of each connection, and decides when a
// connection is read and when it is closed.
//
// To change
// - MBAP, from bytes to requests and back: intake, requests; back-pressure, half-closed clients,
//   the order of answers, and how many are outstanding: client_session.
// - which clients are admitted: clients; which one makes room: sessions; limits of a client
// address:
//   address_limits.
// - idle and frame timeouts: clients, sessions, client_session.
// - the journal's lines about clients: their text: report/asked_text; their number, and denials:
//   gateway/access/report_limit; audit, cleared counters: requests; logins: clients.
#pragma once

#include "gateway/clients/address_limits.hpp"
#include "gateway/clients/requests.hpp"
#include "gateway/input.hpp"

namespace mbgate::gateway {

class Clients {
 public:
  Clients(const SettingsHistory& settings, BusSet& buses, Exchanges& exchanges, WriteRules& rules,
          FailsafeWrites& failsafe, TraceBook& trace, ActionQueue& actions, Instant now);

  /// Lets the client in, or closes its connection.
  void handle(const ClientConnected& input, Instant now);
  void handle(const ClientBytes& input, Instant now);
  void handle(const ClientSent& input, Instant now);
  void handle(const ClientHalfClosed& input, Instant now);
  void handle(const ClientDisconnected& input, Instant now);
  /// Nothing was read since then, though nobody had paused it.
  void stalled(Instant since);
  /// Closes clients whose timeout has passed.
  void handle_deadline(Instant now);
  /// From now on only this much is started. Requests that no bus has yet get 06.
  void set_phase(Phase phase);

  /// Serves a client for which something may be done; false if there is none.
  bool serve_one(Instant now);
  /// All jobs of the request have ended: answers it.
  void complete(std::uint32_t exchange, Instant now) { requests_.complete(exchange, now); }
  /// Removes closed sessions. To be called when nothing else is left to do.
  void sweep() { sessions_.sweep(); }

  /// Before new settings are in force: closes clients that these do not allow.
  void close_unwanted(const Settings& next, Instant now);
  /// The new settings are in force.
  void adopt(const SettingsSnapshot& before, Instant now);
  [[nodiscard]] const Sessions& sessions() const { return sessions_; }
  [[nodiscard]] const ClientCounters& counters() const { return intake_.counters(); }
  /// Those of the buses too.
  void clear_counters() { requests_.clear_counters(); }

 private:
  [[nodiscard]] bool admit(const ClientInfo& info, Instant now);
  /// Closes the connection, if there is one; else the limit is why nobody is let in.
  [[nodiscard]] std::optional<RefusalReason> make_room(ClientSession* displaced,
                                                       RefusalReason limit, Instant now);
  /// Is another request, which is no stop, within the client's rate?
  [[nodiscard]] bool may_ask(const ClientSession& session, Instant now);
  void set_timer(ClientSession& session, Instant now);
  void leave(ClientSession& session, Instant now);
  /// Nobody is told what becomes of its requests.
  void drop_requests(ClientSession& session, Instant now);
  void close(ClientSession& session, Instant now);
  /// Its connection is gone.
  void forget(ClientSession& session, Instant now);

  const SettingsHistory& settings_;
  Exchanges& exchanges_;
  FailsafeWrites& failsafe_;
  ActionQueue& actions_;
  Sessions sessions_;
  Intake intake_;
  Requests requests_;
  AddressLimits limits_;
  ReportLimit logins_{kActsReported};
  ReportLimit over_rate_{kDenialsReported};
};

}  // namespace mbgate::gateway
