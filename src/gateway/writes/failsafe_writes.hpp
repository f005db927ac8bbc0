// SPDX-License-Identifier: Apache-2.0
// Failsafe writes, from when they are due until they were transmitted. Each is sent as a stop
// without a client, as a request of its own.
#pragma once

#include <optional>
#include <vector>

#include "bus/state_reader.hpp"
#include "gateway/clients/sessions.hpp"
#include "gateway/exchanges/exchanges.hpp"
#include "gateway/writes/failsafe.hpp"
#include "gateway/writes/write_rules.hpp"

namespace mbgate::gateway {

class FailsafeWrites {
 public:
  FailsafeWrites(const SettingsHistory& settings, Exchanges& exchanges, WriteRules& rules,
                 ActionQueue& actions)
      : settings_(settings),
        exchanges_(exchanges),
        rules_(rules),
        actions_(actions),
        watch_(settings.in_force().new_failsafe()) {}

  void client_came(const ClientSession& client);
  void client_asked(ClientId client, Instant now);
  void client_waits(ClientId client, bool waits, Instant now) {
    watch_.client_waits(client, waits, now);
  }
  void client_gone(ClientId client) { watch_.client_gone(client); }
  /// Its line was opened: what waits for it is tried again.
  void bus_opened(BusId bus);

  [[nodiscard]] std::optional<Instant> next() const { return watch_.next(); }
  /// Sends what is due; false if nothing is.
  bool send_due(Instant now);
  /// The gateway stops: what is due and what `failsafe_on_exit` asks for is sent; what cannot be
  /// sent any more is reported.
  void send_at_exit(Instant now);
  /// Buses may have transmitted something: notes which writes were sent.
  void note_sent();
  /// One of the requests has ended. What was not transmitted stays due.
  void ended(std::uint32_t exchange);

  /// Before new settings are in force: sends the writes of devices that these do not have any more,
  /// or have elsewhere. Nobody may write to the old place afterwards.
  void send_to_leaving(const Settings& next, Instant now);
  /// New settings are in force, also for the clients that are left.
  void adopt(const SettingsSnapshot& before, const Sessions& clients, Instant now);

 private:
  friend struct mbgate::StateReader;
  struct Write {
    std::optional<std::uint32_t> exchange;  ///< nothing: it has ended
    std::size_t place;                      ///< among the device's failsafe writes
  };
  /// The failsafe writes of a device that are being sent.
  struct Run {
    Failsafe::Due due;
    BusId bus;
    std::uint8_t address;
    std::vector<Write> unsent{};
    std::vector<std::uint32_t> exchanges{};  ///< that have not ended
    /// The device has other failsafe writes now. Unless all of the old ones are sent, all of the
    /// new ones are due.
    bool is_outdated = false;
  };
  void send(Failsafe::Due due, Instant now);
  void note_sent(Run& run);
  [[nodiscard]] bool is_at_its_place(const Run& run) const;
  void end(const Run& run);
  void report(const Run& run, FailsafeOutcome outcome);
  void report(const Failsafe::Due& due, FailsafeOutcome outcome);

  const SettingsHistory& settings_;
  Exchanges& exchanges_;
  WriteRules& rules_;
  ActionQueue& actions_;
  Failsafe watch_;
  std::vector<Run> runs_;
  bool stopping_ = false;
};

}  // namespace mbgate::gateway
