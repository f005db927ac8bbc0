// SPDX-License-Identifier: Apache-2.0
// The stops of a connection that were taken although requests before them were not: they stay in
// the read-ahead and are passed by when reading comes to them. Positions count the bytes of the
// connection's stream.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "gateway/device_index.hpp"
#include "gateway/limits.hpp"
#include "modbus/mbap.hpp"

namespace mbgate::gateway {

class EarlyStops {
 public:
  struct Stop {
    std::uint64_t position;
    /// The client wants its answers in order: this one gets its place when reading comes to it.
    bool answer_waits = false;
    std::optional<std::uint32_t> exchange{};  ///< that has not ended
    std::optional<modbus::MbapAdu> answer{};
  };

  [[nodiscard]] bool has_room() const { return stops_.size() < kStopReserve; }
  void add(const Stop& stop);
  [[nodiscard]] bool has(std::uint64_t position) const {
    return std::ranges::find(stops_, position, &Stop::position) != stops_.end();
  }
  /// A write to the device, which a stop of it lets go first, lies at the position.
  void note_write(std::size_t device, std::uint64_t position);
  /// Forgets the others: reading has come to them, or they will be looked at again.
  void keep_writes(std::uint64_t begin, std::uint64_t end);
  [[nodiscard]] bool write_lies_before(const DevicePlaces& devices, std::uint64_t position) const;
  /// Writes to these devices that lie before the position are overtaken by a stop.
  void forbid(const DevicePlaces& devices, std::uint64_t before);
  [[nodiscard]] bool forbids(std::size_t device, std::uint64_t position) const;
  /// Reading has come to the position: the stop that was taken there, if there was one.
  std::optional<Stop> take(std::uint64_t position);
  /// Keeps the answer for later; false if it needs not wait.
  bool keep_answer(std::uint32_t exchange, const std::optional<modbus::MbapAdu>& answer);
  /// Other settings: the new place of each device, none if it is gone.
  template <typename NewPlace>
  void renumber(NewPlace new_place);

  std::uint64_t looked_at = 0;  ///< whole requests before this position were looked at

 private:
  struct Place {
    std::size_t device;
    std::uint64_t position;
  };
  std::vector<Stop> stops_;       // in the order of their positions
  std::vector<Place> forbidden_;  // writes before the position
  std::vector<Place> writes_;
};

template <typename NewPlace>
void EarlyStops::renumber(NewPlace new_place) {
  std::vector<Place> kept;
  for (const Place& it : forbidden_) {
    if (const std::optional<std::size_t> device = new_place(it.device)) {
      kept.push_back({*device, it.position});
    }
  }
  forbidden_ = std::move(kept);
  writes_.clear();
  looked_at = 0;  // what lies there may reach other devices now
}

}  // namespace mbgate::gateway
