// SPDX-License-Identifier: Apache-2.0
// The whole gateway without its wires: bytes, line states and `now` go in, actions come out.
// After every handle_*() the driver empties poll_action() and re-arms next_wake().
// Single-threaded; no clock, socket, log or random source inside. Spurious and late calls are
// harmless.
#pragma once

#include <list>
#include <map>
#include <memory>
#include <set>
#include <unordered_map>

#include "bus/action_queue.hpp"
#include "bus/bus.hpp"
#include "bus/state_reader.hpp"
#include "gateway/action.hpp"
#include "gateway/client_session.hpp"
#include "gateway/client_timers.hpp"
#include "gateway/exchange.hpp"
#include "gateway/failsafe.hpp"
#include "gateway/settings_diff.hpp"
#include "gateway/settings_snapshot.hpp"
#include "gateway/status_unit.hpp"
#include "gateway/stop_marks.hpp"
#include "gateway/writers.hpp"

namespace mbgate::gateway {

/// A glance for status lines.
struct Status {
  std::size_t clients = 0;
  std::size_t buses_open = 0;
};

/// When the driver is to call handle_deadline() next.
struct Wake {
  Instant at;
  /// A silence ends then on the line of this bus, and something may be transmitted: the driver may
  /// come early and wait for it. Otherwise something is judged, for which it must not come early.
  std::optional<BusId> silence_of = std::nullopt;
};

class Gateway {
 public:
  /// Asks for every line. The settings must be consistent: every bus that is named exists.
  Gateway(Settings settings, Instant now);

  /// The driver numbers clients and uses no number twice. A client that is not wanted is closed.
  void handle_client_connected(ClientId client, const ClientInfo& info, Instant now);
  /// At most kClientReadSize bytes, and how many still lie in the socket behind them. After Resume
  /// the driver reads even if there is nothing: no bytes then say that the socket was empty.
  void handle_client_bytes(ClientId client, modbus::Bytes bytes, Instant now,
                           std::size_t unread = 0);
  /// The oldest Send that was not confirmed yet has been written whole.
  void handle_client_sent(ClientId client, Instant now);
  /// FIN: once when it is noticed while reading is paused, and when reading comes to it.
  void handle_client_half_closed(ClientId client, Instant now);
  /// The connection is gone. Unknown clients are ignored.
  void handle_client_disconnected(ClientId client, Instant now);
  void handle_bus_opened(BusId bus, Instant now, bus::LineKind kind = bus::LineKind::virtual_line);
  void handle_bus_bytes(BusId bus, modbus::Bytes bytes, Instant now);
  /// The line could not be opened, or died, or the far end of a connection has closed it. The
  /// machine asks again by itself.
  void handle_bus_lost(BusId bus, Instant now, bus::Loss loss = bus::Loss::failed);
  /// After Look: what lay in the line has been handed in, and nothing else since.
  void handle_bus_looked(BusId bus, Instant now);
  /// The driver promises that what already lay in the descriptors of open lines has been handed in
  /// before: nothing is judged that could have been known.
  void handle_deadline(Instant now);
  /// Other settings from now on, consistent as in the constructor. Listeners, buses and devices are
  /// the same if their names are; the numbers in actions and inputs are those of the new settings
  /// at once. Lines that did not change go on without losing a transaction; Shut is asked for those
  /// that changed, and Open for these and new ones. The driver drops the lines of buses that are no
  /// more. Clients of listeners that are no more, or do not allow them any more, are closed. To be
  /// called when poll_action() has nothing left: the numbers in older actions are the older ones.
  void handle_settings(Settings settings, Instant now);
  /// Nothing new is begun but stops; Finished follows at most 1.5 s later.
  void handle_shutdown(Instant now);

  /// What lines are to do comes first: a line must not wait while sockets are written.
  std::optional<Action> poll_action();
  [[nodiscard]] std::optional<Wake> next_wake() const;

  [[nodiscard]] const Settings& settings() const { return current().settings; }
  [[nodiscard]] Status status() const;
  /// There is a line, or a connection that is opened as soon as somebody asks.
  [[nodiscard]] bool is_open(BusId bus) const {
    return buses_[static_cast<std::size_t>(bus)]->bus.is_open();
  }

 private:
  friend struct mbgate::StateReader;
  using Sessions = std::unordered_map<ClientId, ClientSession>;
  struct BusSlot {
    template <typename... Arguments>
    explicit BusSlot(Arguments&&... arguments) : bus(std::forward<Arguments>(arguments)...) {}
    bus::Bus bus;
    bool dirty = false;
  };
  struct Source {
    bus::FairnessKey id;
    std::size_t connections;
    unsigned weight;
  };
  /// A request as it was read.
  struct Received {
    const modbus::MbapAdu& adu;
    std::uint64_t position;  ///< in the client's stream
    Instant arrival;
  };

  // gateway.cpp: buses, time
  [[nodiscard]] SettingsSnapshot& current() { return snapshots_.back(); }
  [[nodiscard]] const SettingsSnapshot& current() const { return snapshots_.back(); }
  [[nodiscard]] bus::Bus& touch(BusId id);
  void settle(Instant now);
  void collect(BusId id);
  void finish_if_stopped();
  void report(const Event& event) { actions_.push(Report{event}); }

  // gateway_clients.cpp: who is let in, when a connection is read, when it ends
  bool admit(const ClientInfo& info);
  bool displace_idle_client(ListenerId listener);
  void after_input(ClientId id, ClientSession& session, Instant now);
  void arm(ClientId id, ClientSession& session, Instant at);
  void check_client(ClientId id, Instant now);
  void close(ClientId id);
  void drop_requests(ClientSession& session);
  void forget(Sessions::iterator client);
  void add_connection(const routing::ClientAddress& address);
  [[nodiscard]] unsigned weight_of(const routing::ClientAddress& address) const;

  // gateway_requests.cpp: from the bytes to the buses and back
  /// When the gateway stops, what was read ahead is answered too.
  [[nodiscard]] bool may_take(const ClientSession& session) const {
    return stopping_ || !session.is_full();
  }
  void take_input(ClientId id, ClientSession& session, Instant now);
  std::size_t take_requests(ClientId id, ClientSession& session, modbus::Bytes stream,
                            std::optional<Instant> arrival, Instant now);
  void lose_framing(ClientId id, ClientSession& session, modbus::Bytes stream,
                    std::uint16_t length);
  void notice_rtu(ClientSession& session, modbus::Bytes stream);
  void notice_unrouted(const ClientSession& session, std::uint8_t unit);
  void accept(ClientId id, ClientSession& session, const Received& received, Instant now);
  [[nodiscard]] std::uint32_t open_exchange(ClientId id, ClientSession& session,
                                            const modbus::MbapHeader& header, routing::Plan plan);
  modbus::Pdu answer_status_unit(const ClientSession& session, const modbus::Pdu& request,
                                 Instant now);
  [[nodiscard]] const routing::ResolvedRoute* resolved_route_of(const ClientSession& session,
                                                                std::uint8_t unit) const {
    return current().routes.find(session.info().listener, unit);
  }
  Result<routing::Plan, modbus::ExceptionCode> plan_for(const ClientSession& session,
                                                        const modbus::MbapAdu& adu) const;
  [[nodiscard]] Duration deadline_of(const routing::Route& route, const routing::Plan& plan) const;
  void answer_now(ClientId id, ClientSession& session, const modbus::MbapHeader& header,
                  const modbus::Pdu& pdu);
  void send(ClientId id, ClientSession& session, ClientSession::AnswerId answer,
            const std::optional<modbus::MbapAdu>& adu);

  // gateway_stops.cpp: stops, and who may write
  [[nodiscard]] bool is_stop(const routing::PlannedTransaction& transaction) const;
  [[nodiscard]] bool is_stop(const routing::Plan& plan) const;
  [[nodiscard]] bool stops_on(BusId bus, const routing::Plan& stop) const;
  [[nodiscard]] std::optional<modbus::ExceptionCode> objection(ClientId id,
                                                               const ClientSession& session,
                                                               const routing::Plan& plan,
                                                               const Received& received,
                                                               Instant now) const;
  [[nodiscard]] std::optional<modbus::ExceptionCode> objection_of_devices(
      ClientId id, const ClientSession& session, const routing::Plan& write,
      const Received& received, Instant now) const;
  [[nodiscard]] std::optional<modbus::ExceptionCode> objection_of_devices(
      ClientId id, const ClientSession& session, const routing::PlannedTransaction& write,
      const Received& received, Instant now) const;
  [[nodiscard]] boost::container::small_vector<BusId, 1> left_out_of(ClientId id,
                                                                     const ClientSession& session,
                                                                     const routing::Plan& stop,
                                                                     const Received& received,
                                                                     Instant now) const;
  void note_accepted(const Exchange& exchange, Instant now);
  [[nodiscard]] DevicePlaces overtaken_by(const routing::Plan& stop) const;
  void take_stops_ahead(ClientId id, ClientSession& session, Instant now, bool leaving = false);
  bool look_ahead(ClientId id, ClientSession& session, const Received& received, Instant now);
  std::optional<routing::Plan> write_in(const ClientSession& session,
                                        const modbus::MbapAdu& adu) const;
  void note_ahead(ClientSession& session, const routing::Plan& write, std::uint64_t position) const;
  void accept_ahead(ClientId id, ClientSession& session, const Received& received,
                    routing::Plan plan, Instant now);
  void pass_taken(ClientId id, ClientSession& session, const EarlyStops::Stop& stop);

  // gateway_failsafe.cpp: failsafe writes
  void note_asked(ClientId id, ClientSession& session, Instant now);
  void send_failsafe(Failsafe::Due due, Instant now);
  void note_failsafe_sent();
  void note_failsafe_sent(FailsafeRun& run);
  void end_failsafe(std::uint32_t index);
  void take_failsafe_at_exit(Instant now);
  void report_failsafe(const Failsafe::Due& due, FailsafeOutcome outcome);

  // gateway_settings.cpp: from one generation of settings to the next
  void close_unwanted(const Settings& next, const SettingsDiff& diff, Instant now);
  void end_changed(const SettingsSnapshot& old, const SettingsDiff& diff);
  [[nodiscard]] bool is_changed(const Exchange& exchange, const Exchange::Part& part,
                                const SettingsSnapshot& old, const SettingsDiff& diff) const;
  [[nodiscard]] bool leads_elsewhere(ListenerId listener, const Exchange& exchange,
                                     const Exchange::Part& part, BusId bus) const;
  void replace_buses(const Settings& old, const SettingsDiff& diff, Instant now);
  void end_dead(bus::Bus& dead, Instant now);
  void renumber_clients(const SettingsDiff& diff, Instant now);
  void renumber_devices(const SettingsSnapshot& before, const SettingsDiff& diff, Instant now);

  // gateway_exchanges.cpp: the jobs of a request
  void start(std::uint32_t index, Instant arrival, Instant now);
  void submit_parts(const Exchange& exchange, Instant now);
  [[nodiscard]] bus::Job& new_job(std::uint32_t owner, Instant deadline);
  void end_part(bus::Job& job, bus::Ending ending);
  void note_reconfigured(const Exchange& exchange, const Exchange::Part& part);
  void report_effects(const Exchange& exchange, const Exchange::Part& part, bus::Ending ending);
  void complete(std::uint32_t index);
  void forget_generations();
  void cancel_waiting(std::uint32_t index, bool writes_only);
  /// Takes a job back, or, if it is on the wire, sees to it that nothing more of it follows.
  void end_unsent(const Exchange::Part& part);

  std::list<SettingsSnapshot> snapshots_;  // the last one is in force; others have exchanges left
  StatusUnit status_unit_;
  Pool<Exchange> exchanges_;
  Pool<bus::Job> jobs_;  // outlives the queues that link its jobs
  std::vector<std::unique_ptr<BusSlot>> buses_;
  Sessions sessions_;
  std::vector<std::size_t> listener_clients_;
  ClientCounters client_counters_;
  std::map<routing::ClientAddress, Source> sources_;
  std::vector<bus::FairnessKey> free_sources_;
  ClientTimers timers_;
  StopMarks stop_marks_;
  Writers writers_;
  Failsafe failsafe_;
  std::vector<std::uint32_t> failsafe_runs_;  // exchanges
  std::set<std::pair<ListenerId, routing::ClientAddress>> unrouted_told_;
  std::vector<BusId> dirty_buses_;
  std::vector<ClientId> ready_clients_;
  bus::ActionQueue<Action> line_actions_;
  bus::ActionQueue<Action> actions_;
  Instant started_;
  bool stopping_ = false;
  bool finished_ = false;
  std::optional<Instant> stop_deadline_;
};

}  // namespace mbgate::gateway
