// SPDX-License-Identifier: Apache-2.0
// From a client's bytes to its requests, one at a time: parses them, finds their routes, and
// refuses requests that must not reach a bus.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "gateway/access/report_limit.hpp"
#include "gateway/access/rule_verdict.hpp"
#include "gateway/action.hpp"
#include "gateway/clients/client_session.hpp"
#include "gateway/settings/settings_snapshot.hpp"
#include "gateway/status_unit.hpp"
#include "gateway/writes/write_rules.hpp"

namespace mbgate::gateway {

/// What the gateway still starts.
enum class Phase : std::uint8_t { running, only_stops, nothing };

/// A request as it was read, and what becomes of it.
struct Request {
  // Not an aggregate: all its room, much of which nothing needs, would be filled with zeros first.
  Request(const modbus::MbapAdu& parsed, const ClientInput& input)
      : adu(parsed), arrival(input.arrival()), read_at(input.read_at()) {}

  modbus::MbapAdu adu;
  Instant arrival;           ///< a write is as old as this
  Instant read_at;           ///< and a read as this: it was complete then
  bool for_gateway = false;  ///< for the status unit
  std::optional<modbus::ExceptionCode> refused{};
  const routing::ResolvedRoute* route = nullptr;  ///< nothing: there is none
  std::optional<routing::Plan> plan{};            ///< unless it is refused
  bool is_stop = false;
  RuleVerdict verdict{};

  /// How old it is, for its deadline. A stop that waited through a start is as old as a read.
  [[nodiscard]] Instant asked_at() const {
    const bool waited_through_start = is_stop && arrival == Instant::min();
    return modbus::is_read(adu.pdu.bytes()) || waited_through_start ? read_at : arrival;
  }
  [[nodiscard]] WriteOrigin origin(const ClientSession& session) const {
    return {session.id(), session.info(), session.key(), arrival};
  }
};
class Intake {
 public:
  Intake(const SettingsHistory& settings, const WriteRules& rules, ActionQueue& actions)
      : settings_(settings), rules_(rules), actions_(actions) {}

  /// What comes next in a client's stream. Skips other protocols; a client with a whole request
  /// there has asked.
  struct Front {
    std::optional<modbus::MbapFrame> frame{};  ///< none: it is not whole, or there are enough
    bool framing_lost = false;                 ///< it is not known any more where requests begin
  };
  [[nodiscard]] Front front(ClientSession& session);
  /// Takes the request that front() has found. It is large, and valid until the next call.
  [[nodiscard]] Request& take(ClientSession& session, const modbus::MbapFrame& frame, Instant now);
  /// Of a client that is leaving: the next stop that came whole, valid until the next call; nullptr
  /// if there is no other. Everything else is dropped.
  [[nodiscard]] Request* take_stop(ClientSession& session, Instant now);
  /// Reports once for each client if these bytes look like RTU.
  void notice_rtu(ClientSession& session, modbus::Bytes stream);

  void set_phase(Phase phase) { phase_ = phase; }
  [[nodiscard]] Phase phase() const { return phase_; }
  [[nodiscard]] const ClientCounters& counters() const { return counters_; }
  void clear_counters() { counters_ = {}; }
  /// New settings are in force. Requests that arrived before and whose unit means something else
  /// now are answered 06. Clients that ask for a unit without a route are reported once more.
  void adopt(const SettingsSnapshot& before, Instant now);

 private:
  Request& read(ClientSession& session, const modbus::MbapFrame& frame, Instant now);
  Request& understand(const ClientSession& session, const modbus::MbapAdu& adu);
  void apply_rules(const ClientSession& session, Request& request) const;
  void judge(const ClientSession& session, Request& request, Instant now);
  [[nodiscard]] bool is_outdated(const ClientSession& session, const Request& request) const;
  [[nodiscard]] std::optional<modbus::ExceptionCode> objection(const ClientSession& session,
                                                               const Request& request,
                                                               Instant now) const;
  void notice_unrouted(const ClientSession& session, const Request& request);
  [[nodiscard]] bool is_denied(const ClientSession& session, const Request& request,
                               Instant now) const;

  const SettingsHistory& settings_;
  const WriteRules& rules_;
  ActionQueue& actions_;
  Phase phase_ = Phase::running;
  std::optional<Request> request_;  // the last one
  ClientCounters counters_;
  AccessBook access_;
  DenialReports denials_;
  std::set<std::pair<ListenerId, routing::ClientAddress>> unrouted_reported_;
  /// When a unit of a listener came to mean something else.
  std::map<UnitOfListener, Instant> changed_at_;
};

}  // namespace mbgate::gateway
