// SPDX-License-Identifier: Apache-2.0
// The client side: handles the bytes of each connection, and decides when a connection is read and
// when it is closed.
//
// To change
// - MBAP, from bytes to requests and back: intake, requests; back-pressure, half-closed clients,
//   the order of answers, and how many are outstanding: client_session.
// - admission of clients, making room, connection limits: client_admission; limits of a client
//   address: address_limits.
// - idle and frame timeouts: clients, sessions, client_session.
// - the journal's lines about clients: their text: gateway/asked; their number, and denials:
//   gateway/access/report_limit; audit, cleared counters: requests; logins: client_admission.
#pragma once

#include "gateway/clients/client_admission.hpp"
#include "gateway/clients/requests.hpp"
#include "gateway/input.hpp"

namespace mbgate::gateway {

class Clients {
 public:
  Clients(const SettingsHistory& settings, BusSet& buses, Exchanges& exchanges, WriteRules& rules,
          FailsafeWrites& failsafe, TraceBook& trace, ActionQueue& actions, Instant now);

  void handle(const ClientConnected& input, Instant now);
  void handle(const ClientBytes& input, Instant now);
  void handle(const ClientSent& input, Instant now);
  void handle(const ClientHalfClosed& input, Instant now);
  void handle(const ClientDisconnected& input, Instant now);
  /// Nothing was read since then, though nobody had paused it.
  void stalled(Instant since);
  /// Closes clients whose timeout has passed.
  void handle_deadline(Instant now);
  [[nodiscard]] std::optional<Instant> next_deadline() const { return sessions_.next_look(); }
  /// From now on only this much is started. Requests that no bus has yet get 06.
  void set_phase(Phase phase);

  /// Serves a client for which something may be done; false if there is none.
  bool serve_one(Instant now);
  /// All jobs of the request have ended: answers it.
  void complete(std::uint32_t exchange, Instant now) { requests_.complete(exchange, now); }
  /// Removes closed sessions. To be called when nothing else is left to do.
  void sweep() { sessions_.sweep(); }
  [[nodiscard]] std::size_t size() const { return sessions_.size(); }

  /// Before new settings are in force: closes clients that these do not allow.
  void close_unwanted(const Settings& next, Instant now);
  /// The new settings are in force.
  void adopt(const SettingsSnapshot& before, Instant now);
  [[nodiscard]] const Sessions& sessions() const { return sessions_; }
  [[nodiscard]] const ClientCounters& counters() const { return intake_.counters(); }
  /// Those of the buses too.
  void clear_counters() { requests_.clear_counters(); }

 private:
  void serve(ClientSession& session, Instant now);
  void set_timer(ClientSession& session, Instant now);
  void leave(ClientSession& session, Instant now);

  const SettingsHistory& settings_;
  Exchanges& exchanges_;
  ActionQueue& actions_;
  Sessions sessions_;
  Intake intake_;
  ClientAdmission admission_;
  Requests requests_;
};

}  // namespace mbgate::gateway
