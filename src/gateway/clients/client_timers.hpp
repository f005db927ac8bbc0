// SPDX-License-Identifier: Apache-2.0
// When a client must be checked next (idle timeout, incomplete request). One entry for each client;
// one that is checked too early is entered again.
#pragma once

#include <optional>
#include <set>
#include <utility>

#include "gateway/client.hpp"

namespace mbgate::gateway {

class ClientTimers {
 public:
  /// Sets the client's time, in place of the one that it had (`before`).
  void set(ClientId client, std::optional<Instant> before, Instant at) {
    cancel(client, before);
    entries_.emplace(at, client);
  }
  void cancel(ClientId client, std::optional<Instant> before) {
    if (before) {
      entries_.erase({*before, client});
    }
  }
  [[nodiscard]] std::optional<Instant> next() const {
    return entries_.empty() ? std::nullopt : std::optional(entries_.begin()->first);
  }
  /// Removes and returns a client whose time has come; nothing if there is none.
  std::optional<ClientId> take_due(Instant now) {
    if (entries_.empty() || entries_.begin()->first > now) {
      return std::nullopt;
    }
    return entries_.extract(entries_.begin()).value().second;
  }

 private:
  std::set<std::pair<Instant, ClientId>> entries_;
};

}  // namespace mbgate::gateway
