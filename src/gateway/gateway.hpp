// SPDX-License-Identifier: Apache-2.0
// The whole gateway without its wires: bytes, line states and `now` go in, actions come out.
// After every handle_*() the driver empties poll_action() and re-arms next_wake().
// Single-threaded; no clock, socket, log or random source inside. Spurious and late calls are
// harmless.
#pragma once

#include <optional>

#include "gateway/clients.hpp"

namespace mbgate::gateway {

/// A glance for status lines.
struct Status {
  std::size_t clients = 0;
  std::size_t buses_open = 0;
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

  [[nodiscard]] const Settings& settings() const { return settings_.settings(); }
  [[nodiscard]] Status status() const;
  /// There is a line, or a connection that is opened as soon as somebody asks.
  [[nodiscard]] bool is_open(BusId bus) const { return buses_[bus].is_open(); }

 private:
  friend struct mbgate::StateReader;
  void settle(Instant now);
  bool settle_one(Instant now);
  void collect(BusId bus);
  void carry_out(BusId bus, const bus::BusAction& action);
  void adopt_buses(const SettingsDiff& diff, Instant now);
  void report(const Event& event) { actions_.push(Report{event}); }

  bus::ActionQueue<Action> line_actions_;
  ActionQueue actions_;
  SettingsHistory settings_;
  Exchanges exchanges_;  // its jobs outlive the queues that link them
  BusSet buses_;
  WriteRules rules_;
  FailsafeWrites failsafe_;
  Clients clients_;
  bool stopping_ = false;
  bool finished_ = false;
  std::optional<Instant> stop_deadline_;
};

}  // namespace mbgate::gateway
