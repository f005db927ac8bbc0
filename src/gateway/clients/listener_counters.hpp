// SPDX-License-Identifier: Apache-2.0
// The counters of one listener, for all its clients together.
#pragma once

#include <array>
#include <cstdint>

#include "bus/counters.hpp"
#include "gateway/event.hpp"

namespace mbgate::gateway {

/// The reasons for metrics and status, by RefusalReason.
inline constexpr std::array kRefusalNames = {"not_allowed", "full",         "stopping",
                                             "no_rule",     "address_full", "too_often"};

struct ListenerCounters {
  std::uint64_t connections = 0;  ///< let in
  /// Of these, closed to make room for others, because of max_connections and of
  /// max_connections_per_address.
  std::uint64_t displaced_full = 0;
  std::uint64_t displaced_address_full = 0;
  std::uint64_t requests = 0;
  std::uint64_t over_rate = 0;  ///< requests beyond max_requests_per_second of their client
  /// Requests that the gateway itself has answered with an exception.
  bus::ExceptionCounts refused_reads;
  bus::ExceptionCounts refused_writes;
  /// Connections that were not let in, by RefusalReason.
  std::array<std::uint64_t, kRefusalNames.size()> refused_connections{};

  void note_refused(bool is_read, std::uint8_t code) {
    (is_read ? refused_reads : refused_writes).note(code);
  }
  void note_displaced(RefusalReason limit) {
    ++(limit == RefusalReason::full ? displaced_full : displaced_address_full);
  }
  void note_refused(RefusalReason reason) {
    ++refused_connections.at(static_cast<std::size_t>(reason));
  }
};

}  // namespace mbgate::gateway
