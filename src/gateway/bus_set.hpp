// SPDX-License-Identifier: Apache-2.0
// The buses of the gateway: which of them have actions to be polled, and when one must be woken
// next.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "bus/bus.hpp"
#include "gateway/settings.hpp"

namespace mbgate::gateway {

/// When the driver is to hand in DeadlineReached next.
struct Wake {
  Instant at;
  /// Set: a silence on the line of this bus ends then, and something may be transmitted. The driver
  /// may wake early and wait for the exact instant. None: something is decided then, and the driver
  /// must not come early.
  std::optional<BusId> silence_of = std::nullopt;
};

class BusSet {
 public:
  /// Asks for every line to be opened.
  explicit BusSet(const Settings& settings);

  /// False for a bus that a reload has removed. Only inputs from outside can still have its number.
  [[nodiscard]] bool is_there(BusId id) const {
    return buses_[static_cast<std::size_t>(id)].bus != nullptr;
  }
  [[nodiscard]] const bus::Bus& operator[](BusId id) const;
  /// For calls that may change the bus: its actions are then to be polled.
  [[nodiscard]] bus::Bus& touch(BusId id);
  /// A bus whose actions are to be polled, or nothing.
  std::optional<BusId> take_touched();
  std::optional<bus::BusAction> poll(BusId id);

  [[nodiscard]] std::size_t open_count() const;
  /// The longest time that one ordinary transaction takes on any of these buses.
  [[nodiscard]] Duration longest_transaction(std::span<const BusId> buses) const;
  /// The earliest wake of all buses and of `judgement`, a deadline of the gateway itself.
  [[nodiscard]] std::optional<Wake> next_wake(std::optional<Instant> judgement) const;
  /// Wakes the buses whose time has come.
  void handle_deadline(Instant now);
  /// Calls `change` with each bus, whose actions are then to be polled.
  template <typename Change>
  void touch_all(Change change) {
    for_each([&](BusId id, const bus::Bus&) { change(touch(id)); });
  }
  /// Each transmission is told, of buses to come too.
  void set_traced(bool traced);
  /// Calls `visit` with the number of each bus, and the bus.
  template <typename Visit>
  void for_each(Visit visit) const {
    for (std::size_t place = 0; place < buses_.size(); ++place) {
      if (buses_[place].bus != nullptr) {
        visit(id_of(place), *buses_[place].bus);
      }
    }
  }

  /// A bus that is not in the new settings, or gets another line there.
  struct GivenUp {
    BusId id;
    std::unique_ptr<bus::Bus> bus;
  };
  /// New settings: buses that keep their line go on, and others are started. Returns those given
  /// up.
  std::vector<GivenUp> adopt(const Settings& old, const Settings& next, Instant now);

 private:
  struct Slot {
    std::unique_ptr<bus::Bus> bus;  ///< none: removed
    bool touched = false;
  };
  void begin(BusId id, const Settings& settings);
  [[nodiscard]] BusId id_of(std::size_t place) const {
    return BusId{static_cast<std::uint32_t>(place)};
  }

  std::vector<Slot> buses_;
  std::vector<BusId> touched_;
  bool traced_ = false;
};

}  // namespace mbgate::gateway
