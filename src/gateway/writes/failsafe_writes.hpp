// SPDX-License-Identifier: Apache-2.0
// Failsafe writes: sent to a device when the client that counts has gone, or is silent. The clients
// in `failsafe_clients` count, else the client that wrote to the device last. They are due until
// the device has acknowledged all of them, or such a client has asked it again. A device to which
// nobody has written since gets none. Each is a request of its own, a stop without a client.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "gateway/clients/sessions.hpp"
#include "gateway/exchanges/exchanges.hpp"
#include "gateway/writes/write_rules.hpp"

namespace mbgate::gateway {

/// After the process stood still the driver reads all sockets at once: long before this is over.
inline constexpr Duration kToRead = std::chrono::milliseconds(100);

class FailsafeWrites {
 public:
  FailsafeWrites(const SettingsHistory& settings, Exchanges& exchanges, WriteRules& rules,
                 ActionQueue& actions);

  /// A client has asked devices something. `writes`: it is accepted, and neither a read nor a stop.
  void client_asked(const ClientSession& client, const routing::Plan& plan, bool writes,
                    Instant now);
  void client_gone(ClientId client, Instant now);

  /// When send_due() may have something to do, at the earliest.
  [[nodiscard]] std::optional<Instant> next() const {
    return earliest_ ? std::optional(std::max(*earliest_, not_before_)) : std::nullopt;
  }
  /// The process stood still: nobody counts as silent before what lies in the sockets is read.
  void stalled(Instant now) { not_before_ = now + kToRead; }
  /// Sends what is due; false if nothing is.
  bool send_due(Instant now);
  /// The gateway stops: sends what `failsafe_on_exit` asks for, and reports what stays due.
  void send_at_exit(Instant now);
  /// A request has ended, a client's or one of these.
  void ended(std::uint32_t exchange, Instant now);
  /// New settings are in force. What is at the same address of the same port is the same drive.
  void adopt(const SettingsSnapshot& before);

 private:
  struct Write {
    std::optional<std::uint32_t> exchange{};  ///< on its way
    bool is_acknowledged = false;
  };
  struct Watch {
    std::map<ClientId, const ClientSession*> connections;  ///< that have asked the device
    /// Who wrote last; nothing: nobody since the failsafe writes were acknowledged.
    std::optional<ClientKey> writer;
    bool is_written_to = false;        ///< since they were begun, by a client that does not count
    Instant active = Instant::min();   ///< when one that counts asked, or was answered
    std::optional<Instant> gone_at{};  ///< the last such connection ended; nobody asked since
    std::optional<FailsafeReason> due{};
    bool is_reported = false;        ///< that they are not acknowledged yet
    Instant again = Instant::min();  ///< due: they are sent then
    std::vector<Write> writes{};     ///< due: as the guard has them
    [[nodiscard]] bool is_under_way() const;
  };
  [[nodiscard]] const DeviceGuard& guard(std::size_t device) const;
  [[nodiscard]] bool counts(std::size_t device, const Watch& watch, ClientId client) const;
  [[nodiscard]] bool does_one_count(std::size_t device, const Watch& watch) const;
  [[nodiscard]] bool is_waited_for(std::size_t device, const Watch& watch) const;
  [[nodiscard]] std::optional<Instant> acts_at(std::size_t device, const Watch& watch) const;
  template <typename Visit>
  void visit_reached(const routing::Plan& plan, Visit visit);
  bool act(std::size_t device, Watch& watch, Instant now);
  void begin(std::size_t device, Watch& watch, FailsafeReason reason);
  void abandon(Watch& watch);
  void send(std::size_t place, Watch& watch, Instant now);
  void end_run(std::size_t device, Watch& watch);
  void report(const drive::Device& device, const Watch& watch, FailsafeOutcome outcome);

  const SettingsHistory& settings_;
  Exchanges& exchanges_;
  WriteRules& rules_;
  ActionQueue& actions_;
  std::map<std::size_t, Watch> watches_;  // of the devices that have failsafe writes
  std::optional<Instant> earliest_;       // no watch acts before
  Instant not_before_ = Instant::min();   // nor before this
  bool stopping_ = false;
};

}  // namespace mbgate::gateway
