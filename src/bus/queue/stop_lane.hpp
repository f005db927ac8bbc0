// SPDX-License-Identifier: Apache-2.0
// The stops that wait for a bus, ahead of everything else, in the order in which they are sent.
// Identical ones share a place. Those that their device has refused rest before their next try, and
// hold up nobody meanwhile.
#pragma once

#include <algorithm>
#include <boost/intrusive/list.hpp>
#include <cstddef>
#include <optional>
#include <vector>

#include "bus/job.hpp"

namespace mbgate::bus {

/// The most stops of one client to one address that may wait, in addition to the limit of the
/// queue. Identical ones share a place; this is also the most of one client that may share one.
inline constexpr std::size_t kRoomForStops = 256;

class StopLane {
 public:
  [[nodiscard]] bool has_room(const Job& stop) {
    std::size_t stops = 0;
    visit([&](const Job& it) {
      stops += it.address() == stop.address() && it.source == stop.source ? 1U : 0U;
    });
    return stops < kRoomForStops;
  }
  /// Behind the others.
  void push(Job& stop) { stops_.push_back(stop); }
  /// Before those that were accepted later and were not tried yet.
  void push_in_order(Job& stop) {
    const auto later = std::ranges::find_if(stops_, [&](const Job& other) {
      return other.sent.tries == 0 && other.sequence > stop.sequence;
    });
    stops_.insert(later, stop);
  }
  /// In front of them.
  void push_front(Job& stop) { stops_.push_front(stop); }
  /// It waits again from `until` on.
  void rest(Job& stop, Instant until) {
    stop.sent.waits_since = until;
    resting_.push_back(stop);
  }
  /// Those whose rest is over wait, behind the others.
  void wake(Instant now) {
    while (!resting_.empty() && resting_.front().sent.waits_since <= now) {
      stops_.splice(stops_.end(), resting_, resting_.begin());
    }
  }
  [[nodiscard]] std::optional<Instant> next_wake() const {
    return resting_.empty() ? std::nullopt : std::optional(resting_.front().sent.waits_since);
  }
  void remove(Job& stop) { stops_.erase(List::s_iterator_to(stop)); }

  [[nodiscard]] bool empty() const { return stops_.empty(); }
  /// The number of places in use: stops that share one count once.
  [[nodiscard]] std::size_t size() const { return stops_.size() + resting_.size(); }
  /// The first for which `is_it` returns true; nullptr if there is none.
  template <typename Predicate>
  [[nodiscard]] Job* find(Predicate is_it) {
    const auto found = std::ranges::find_if(stops_, is_it);
    return found == stops_.end() ? nullptr : &*found;
  }
  /// The same among those that rest, too.
  template <typename Predicate>
  [[nodiscard]] Job* find_any(Predicate is_it) {
    const auto resting = std::ranges::find_if(resting_, is_it);
    return resting == resting_.end() ? find(is_it) : &*resting;
  }
  /// Calls `visit` for each of them; the lane must not be changed meanwhile.
  template <typename Visit>
  void visit(Visit visit) {
    std::ranges::for_each(stops_, visit);
    std::ranges::for_each(resting_, visit);
  }

 private:
  using List = boost::intrusive::list<
      Job,
      boost::intrusive::member_hook<Job, boost::intrusive::list_member_hook<>, &Job::stop_hook>>;
  List stops_;
  List resting_;  // by the end of their rest
};

// Which stops devices acknowledged a moment ago, with nothing but stops for them since: another one
// like it is no hurry, and must not keep the line from others. A client that sends stops without a
// pause would have the line for itself, because stops go before everything else.

/// For so long a stop that was acknowledged counts.
inline constexpr Duration kStopCountsFor = std::chrono::seconds(1);
/// So many different stops of a device go first within that time; then it has been stopped enough.
inline constexpr std::size_t kMostDifferentStops = 8;

class AcknowledgedStops {
 public:
  /// The device acknowledged the stop. A broadcast, which nobody acknowledges, was sent.
  void note(const Transaction& stop, Instant now) {
    std::erase_if(stops_,
                  [&](const Stop& it) { return is_over(it, now) || it.sent.is_like(stop); });
    stops_.push_back({stop, now});
  }
  /// Something else may have happened to the device: a write was accepted, or a request failed.
  void forget(std::uint8_t address) {
    std::erase_if(stops_, [&](const Stop& it) {
      return it.sent.address == address || it.sent.is_broadcast();
    });
  }
  /// A broadcast was accepted that stops a device; to others it may be an ordinary write.
  void forget_single() {
    std::erase_if(stops_, [](const Stop& it) { return !it.sent.is_broadcast(); });
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
    Transaction sent;  ///< to another unit, where a server is one device under every unit
    Instant at;
  };
  static bool is_over(const Stop& stop, Instant now) { return now >= stop.at + kStopCountsFor; }
  [[nodiscard]] bool has(const Transaction& stop, Instant now) const {
    const auto counts = [&](const Stop& it) {
      return it.sent.address == stop.address && it.sent.unit == stop.unit && !is_over(it, now);
    };
    const auto different = static_cast<std::size_t>(std::ranges::count_if(stops_, counts));
    return different >= kMostDifferentStops || std::ranges::any_of(stops_, [&](const Stop& it) {
             return counts(it) && it.sent.is_like(stop);
           });
  }

  std::vector<Stop> stops_;
};

}  // namespace mbgate::bus
