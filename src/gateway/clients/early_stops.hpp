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

  /// Begins a search of the read-ahead behind `front`: all of it, or what was not searched before.
  void begin_look(std::uint64_t front, bool at_all);
  [[nodiscard]] std::uint64_t looking_at() const { return looking_at_; }
  void look_past(std::size_t bytes) { looking_at_ += bytes; }
  void end_look() { looked_at_ = looking_at_; }
  /// Processing has reached the position, from which a stop was taken: returns that.
  Stop take(std::uint64_t position);
  /// Keeps the answer for later; false if it need not wait.
  bool keep_answer(std::uint32_t exchange, const std::optional<modbus::MbapAdu>& answer);
  /// New settings: requests in the read-ahead may go to other devices now.
  void look_again() { looked_at_ = 0; }

 private:
  std::vector<Stop> stops_;      // in the order of their positions
  std::uint64_t looked_at_ = 0;  // whole requests before this position were looked at
  std::uint64_t looking_at_ = 0;
};

}  // namespace mbgate::gateway
