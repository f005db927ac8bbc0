// SPDX-License-Identifier: Apache-2.0
// The stops of a connection that were taken from the read-ahead although earlier requests still
// wait there. Their bytes stay in the read-ahead and are skipped when processing reaches them.
// Positions count the bytes of the connection's stream.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "gateway/limits.hpp"
#include "gateway/settings/device_index.hpp"
#include "modbus/mbap.hpp"

namespace mbgate::gateway {

class EarlyStops {
 public:
  struct Stop {
    std::uint64_t position;
    /// `ordered = true`: the answer gets its place when processing reaches the stop.
    bool answer_waits = false;
    std::optional<std::uint32_t> exchange{};  ///< that has not ended
    std::optional<modbus::MbapAdu> answer{};
  };

  [[nodiscard]] bool has_room() const { return stops_.size() < kStopReserve; }
  void add(const Stop& stop);
  [[nodiscard]] bool has(std::uint64_t position) const {
    return std::ranges::find(stops_, position, &Stop::position) != stops_.end();
  }

  /// Was the stop at the position taken, or does one behind it wait for the writes before it?
  /// Then nothing may hold up what lies there.
  [[nodiscard]] bool goes_on(std::uint64_t position) const {
    return has(position) || (first_held_ && *first_held_ >= position);
  }

  /// Begins a search of the read-ahead behind `front`: all of it, or what was not searched before.
  void begin_look(std::uint64_t front, bool at_all);
  [[nodiscard]] std::uint64_t looking_at() const { return looking_at_; }
  void look_past(std::size_t bytes) { looking_at_ += bytes; }
  /// The stop at `position` lets a write before it go first: it will be looked at again.
  void hold(std::uint64_t position) { first_held_ = first_held_.value_or(position); }
  void end_look() { looked_at_ = first_held_.value_or(looking_at_); }
  /// At the position is a write to the device that the device's stops let go first.
  void note_write(std::size_t device, std::uint64_t position);
  [[nodiscard]] bool write_lies_before(const DevicePlaces& devices, std::uint64_t position) const;
  /// Processing has reached the position, from which a stop was taken: returns that.
  Stop take(std::uint64_t position);
  /// Keeps the answer for later; false if it need not wait.
  bool keep_answer(std::uint32_t exchange, const std::optional<modbus::MbapAdu>& answer);
  /// New settings: requests in the read-ahead may go to other devices now.
  void look_again() {
    writes_.clear();
    looked_at_ = 0;
  }

 private:
  struct Place {
    std::size_t device;
    std::uint64_t position;
  };
  std::vector<Stop> stops_;  // in the order of their positions
  std::vector<Place> writes_;
  std::uint64_t looked_at_ = 0;  // whole requests before this position were looked at
  std::uint64_t looking_at_ = 0;
  std::optional<std::uint64_t> first_held_;
};

}  // namespace mbgate::gateway
