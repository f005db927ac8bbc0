// SPDX-License-Identifier: Apache-2.0
// Which stops devices acknowledged a moment ago, with nothing but stops for them since: another one
// like it is no hurry, and must not keep the line from others. A client that sends stops without a
// pause would have the line for itself, because stops go before everything else.
#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "bus/job.hpp"

namespace mbgate::bus {

/// For so long a stop that was acknowledged counts.
inline constexpr Duration kStopCountsFor = std::chrono::seconds(1);
/// So many different stops of a device go first within that time; then it has been stopped enough.
inline constexpr std::size_t kMostDifferentStops = 8;

class AcknowledgedStops {
 public:
  /// The device acknowledged the stop. A broadcast, which nobody acknowledges, was sent.
  void note(const Transaction& stop, Instant now) {
    std::erase_if(stops_, [&](const Stop& it) { return is_over(it, now) || is_same(it, stop); });
    stops_.push_back({stop.address, stop.unit, stop.broadcast, stop.request.pdu(), now});
  }
  /// Something else may have happened to the device: a write was accepted, or a request failed.
  void forget(std::uint8_t address) {
    std::erase_if(stops_,
                  [&](const Stop& it) { return it.address == address || is_broadcast(it); });
  }
  /// A broadcast was accepted that stops a device; to others it may be an ordinary write.
  void forget_single() {
    std::erase_if(stops_, [](const Stop& it) { return !is_broadcast(it); });
  }
  void forget_all() { stops_.clear(); }
  /// Would the stop only repeat what the devices have just done?
  [[nodiscard]] bool has(const Job& stop, Instant now) const {
    return !stops_.empty() &&
           std::ranges::all_of(stop.transactions, [&](const Transaction& transaction) {
             return transaction.must_hold != nullptr || has(transaction, now);
           });
  }

 private:
  struct Stop {
    std::uint8_t address;
    std::uint8_t unit;  ///< another one, where a server is one device under every unit
    std::optional<drive::BroadcastForm> broadcast;
    modbus::Pdu request;
    Instant at;
  };
  static bool is_broadcast(const Stop& stop) { return stop.broadcast.has_value(); }
  static bool is_over(const Stop& stop, Instant now) { return now >= stop.at + kStopCountsFor; }
  static bool is_same(const Stop& stop, const Transaction& other) {
    return stop.address == other.address && stop.unit == other.unit &&
           stop.broadcast == other.broadcast && stop.request == other.request.pdu();
  }
  [[nodiscard]] bool has(const Transaction& stop, Instant now) const {
    const auto counts = [&](const Stop& it) {
      return it.address == stop.address && !is_over(it, now);
    };
    const auto different = static_cast<std::size_t>(std::ranges::count_if(stops_, counts));
    return different >= kMostDifferentStops || std::ranges::any_of(stops_, [&](const Stop& it) {
             return counts(it) && is_same(it, stop);
           });
  }

  std::vector<Stop> stops_;
};

}  // namespace mbgate::bus
