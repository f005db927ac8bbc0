// SPDX-License-Identifier: Apache-2.0
// Admits and removes clients: which clients are admitted, which one makes room, the limits of a
// client address, and which requests are cancelled when a client disconnects.
#pragma once

#include <optional>

#include "gateway/access/report_limit.hpp"
#include "gateway/action.hpp"
#include "gateway/clients/address_limits.hpp"
#include "gateway/clients/intake.hpp"
#include "gateway/clients/sessions.hpp"
#include "gateway/exchanges/exchanges.hpp"
#include "gateway/limits.hpp"
#include "gateway/settings/settings_snapshot.hpp"
#include "gateway/writes/failsafe_writes.hpp"

namespace mbgate::gateway {

class ClientAdmission {
 public:
  ClientAdmission(const SettingsHistory& settings, Exchanges& exchanges, FailsafeWrites& failsafe,
                  Sessions& sessions, ActionQueue& actions)
      : settings_(settings),
        exchanges_(exchanges),
        failsafe_(failsafe),
        sessions_(sessions),
        actions_(actions) {}

  /// Lets the client in, or closes its connection.
  void connected(ClientId client, const ClientInfo& info, Phase phase, Instant now);
  /// Is another request, which is no stop, within the client's rate?
  [[nodiscard]] bool may_ask(const ClientSession& session, Instant now);
  /// Nobody is told what becomes of its requests.
  void drop_requests(ClientSession& session);
  /// Closes its connection.
  void close(ClientSession& session, Instant now);
  /// Its connection is gone.
  void forget(ClientSession& session, Instant now);

 private:
  [[nodiscard]] bool admit(const ClientInfo& info, Phase phase, Instant now);
  [[nodiscard]] std::optional<RefusalReason> objection(const ClientInfo& info, Phase phase,
                                                       Instant now) const;
  /// Closes the connection, if there is one; else the limit is why nobody is let in.
  [[nodiscard]] std::optional<RefusalReason> make_room(ClientSession* displaced,
                                                       RefusalReason limit, Instant now);
  void refuse(const ClientInfo& info, RefusalReason reason);
  /// The journal is told of a client that has shown a certificate.
  void notice_login(const ClientInfo& info, Instant now);

  const SettingsHistory& settings_;
  Exchanges& exchanges_;
  FailsafeWrites& failsafe_;
  Sessions& sessions_;
  ActionQueue& actions_;
  AddressLimits limits_;
  ReportLimit logins_{kActsReported};
};

}  // namespace mbgate::gateway
