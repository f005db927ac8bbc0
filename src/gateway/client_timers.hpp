// SPDX-License-Identifier: Apache-2.0
// When a client must be looked at next (idle, partial frame). Entries are not taken back: a client
// that is looked at too early just asks again.
#pragma once

#include <optional>
#include <queue>
#include <utility>
#include <vector>

#include "gateway/event.hpp"

namespace mbgate::gateway {

class ClientTimers {
 public:
  void arm(ClientId client, Instant at) { entries_.emplace(at, client); }
  [[nodiscard]] std::optional<Instant> next() const {
    return entries_.empty() ? std::nullopt : std::optional(entries_.top().first);
  }
  /// A client whose time has come, and the time it was armed for.
  std::optional<std::pair<Instant, ClientId>> take_due(Instant now) {
    if (entries_.empty() || entries_.top().first > now) {
      return std::nullopt;
    }
    const auto entry = entries_.top();
    entries_.pop();
    return entry;
  }

 private:
  using Entry = std::pair<Instant, ClientId>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> entries_;
};

}  // namespace mbgate::gateway
