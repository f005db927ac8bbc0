// SPDX-License-Identifier: Apache-2.0
// The open requests and their jobs: from the plan to the buses and back. There are no callbacks:
// requests whose jobs have all ended are polled.
//
// To change
// - which exception a failure becomes, and the journal's lines about a write that ended half-way,
// or
//   that changed how a drive is reached: exchange.
#pragma once

#include <cstdint>
#include <memory>
#include <new>
#include <optional>
#include <ranges>
#include <span>
#include <vector>

#include "bus/action_queue.hpp"
#include "gateway/action.hpp"
#include "gateway/bus_set.hpp"
#include "gateway/exchanges/exchange.hpp"

namespace mbgate::gateway {

// Reusable objects. An object has a stable address while it is in use. The pool grows to the
// largest number ever in use. Each member of an object has an initialiser or a constructor: nothing
// is filled with zeros before, which takes long where there is room for several PDUs.

template <typename Object>
class Pool {
 public:
  std::uint32_t take() {
    if (free_.empty()) {
      objects_.push_back(std::make_unique<Object>());
      return static_cast<std::uint32_t>(objects_.size() - 1);
    }
    const std::uint32_t index = free_.back();
    free_.pop_back();
    return index;
  }
  void give_back(std::uint32_t index) {
    Object* const object = objects_[index].get();
    std::destroy_at(object);
    ::new (static_cast<void*>(object)) Object;
    free_.push_back(index);
  }
  Object& operator[](std::uint32_t index) { return *objects_[index]; }
  /// All objects; those that are not in use are as new.
  [[nodiscard]] auto all() const {
    return objects_ |
           std::views::transform([](const auto& object) -> const Object& { return *object; });
  }
  [[nodiscard]] std::size_t in_use() const { return objects_.size() - free_.size(); }

 private:
  std::vector<std::unique_ptr<Object>> objects_;
  std::vector<std::uint32_t> free_;
};

class Exchanges {
 public:
  Exchanges(SettingsHistory& settings, BusSet& buses, ActionQueue& actions)
      : settings_(settings), buses_(buses), actions_(actions) {}

  /// A new exchange, with the settings in force. Returns its index.
  std::uint32_t open(std::optional<routing::Plan>&& plan);
  [[nodiscard]] Exchange& operator[](std::uint32_t index) { return exchanges_[index]; }
  /// When the time of a request that arrived at `exchange.arrival` is over.
  [[nodiscard]] Instant deadline_of(const Exchange& exchange) const;
  /// Starts to carry out the plan.
  void start(std::uint32_t index, Turns turns, Instant now);
  /// Ends one that is held: nothing of it was sent.
  void refuse(std::uint32_t index);
  /// Adds a job to an exchange; it is still to be submitted.
  bus::Job& add_job(std::uint32_t index, BusId bus, Turns turns, Instant deadline);
  void submit(std::uint32_t index, Instant now);
  /// A stop of a client whose bus was given up: the bus that has its number now begins it anew.
  /// False: it is none, or was abandoned.
  bool begin_anew(bus::Job& job, BusId bus, Instant now);
  /// A bus has ended a job.
  void end(bus::Job& job, bus::Ending ending);
  /// Withdraws what waits. What is on the wire goes on, but is not repeated for a client that has
  /// gone. Stops are carried out even if their client has gone.
  void cancel(std::uint32_t index);
  /// The same, but a write of which a part was on the wire is finished.
  void take_back(std::uint32_t index);

  /// Sees to it that no more of its stops is sent.
  void abandon(std::uint32_t index);

  /// An exchange whose jobs have all ended, which is then to be closed; nothing if there is none.
  std::optional<std::uint32_t> take_completed();
  void close(std::uint32_t index);
  template <typename Predicate>
  [[nodiscard]] bool any_of(Predicate is_it) const {
    return std::ranges::any_of(exchanges_.all(), is_it);
  }
  [[nodiscard]] std::size_t open_count() const { return exchanges_.in_use(); }
  /// The transactions of their plans.
  [[nodiscard]] std::size_t planned() const { return planned_; }
  /// Those of the plans of these.
  [[nodiscard]] std::size_t planned(std::span<const std::uint32_t> indexes);

  /// New settings are in force: jobs that would mean something else now are withdrawn.
  void end_changed(const SettingsSnapshot& old);

 private:
  void end_unsent(const Exchange::Part& part);

  SettingsHistory& settings_;
  BusSet& buses_;
  ActionQueue& actions_;
  Pool<Exchange> exchanges_;
  Pool<bus::Job> jobs_;
  bus::ActionQueue<std::uint32_t> completed_;
  std::size_t planned_ = 0;
};

}  // namespace mbgate::gateway
