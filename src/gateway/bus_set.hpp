// SPDX-License-Identifier: Apache-2.0
// The buses of the gateway: which of them have something to say, and when one must be woken next.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "bus/bus.hpp"
#include "bus/state_reader.hpp"
#include "gateway/settings.hpp"

namespace mbgate::gateway {

/// When the driver is to hand in DeadlineReached next.
struct Wake {
  Instant at;
  /// A silence ends then on the line of this bus, and something may be transmitted: the driver may
  /// come early and wait for it. Otherwise something is judged, for which it must not come early.
  std::optional<BusId> silence_of = std::nullopt;
};

class BusSet {
 public:
  /// Asks for every line.
  explicit BusSet(const Settings& settings);

  /// Of the others no number is left anywhere but outside.
  [[nodiscard]] bool is_there(BusId id) const {
    return buses_[static_cast<std::size_t>(id)].bus != nullptr;
  }
  [[nodiscard]] const bus::Bus& operator[](BusId id) const;
  /// For whatever may change the bus: it is then one of those that have something to say.
  [[nodiscard]] bus::Bus& touch(BusId id);
  /// A bus whose actions are to be polled, or nothing.
  std::optional<BusId> take_touched();
  std::optional<bus::BusAction> poll(BusId id);

  [[nodiscard]] std::size_t open_count() const;
  /// Of these buses.
  [[nodiscard]] Duration longest_response_timeout(std::span<const BusId> buses) const;
  /// The earliest of all buses and `judgement`.
  [[nodiscard]] std::optional<Wake> next_wake(std::optional<Instant> judgement) const;
  /// Wakes those whose time has come.
  void handle_deadline(Instant now);
  /// Nothing new is begun but stops.
  void stop(Instant now);
  /// What is still on the wire ends.
  void give_up(Instant now);
  void clear_counters();

  /// A bus that is not in the settings any more, or gets another line.
  struct GivenUp {
    BusId id;
    std::unique_ptr<bus::Bus> bus;
  };
  /// Other settings: buses that keep their line go on, and others are begun.
  std::vector<GivenUp> adopt(const Settings& old, const Settings& next, Instant now);

 private:
  friend struct mbgate::StateReader;
  struct Slot {
    std::unique_ptr<bus::Bus> bus;  ///< none: it is gone
    bool touched = false;
  };
  void begin(BusId id, const Settings& settings);
  template <typename Visit>
  void for_each(Visit visit) const {
    for (std::size_t place = 0; place < buses_.size(); ++place) {
      if (buses_[place].bus != nullptr) {
        visit(id_of(place), *buses_[place].bus);
      }
    }
  }
  [[nodiscard]] BusId id_of(std::size_t place) const {
    return BusId{static_cast<std::uint32_t>(place)};
  }

  std::vector<Slot> buses_;
  std::vector<BusId> touched_;
};

}  // namespace mbgate::gateway
