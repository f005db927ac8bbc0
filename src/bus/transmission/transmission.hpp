// SPDX-License-Identifier: Apache-2.0
// The transmissions of a bus, each by the job that leads it.
#pragma once

#include <span>
#include <vector>

#include "bus/bus_action.hpp"
#include "bus/job.hpp"

namespace mbgate::bus {

/// For whom it is, for a trace.
[[nodiscard]] TransmissionTitle title_of(const Job& leader);

/// A transmission runs from its first frame on the wire until it is over, also between two tries
/// and between the transactions of a job. A stop waits in the stop lane before its first try and
/// between its tries.
class Transmissions {
 public:
  /// `room`: the most that may be in flight at the same time.
  explicit Transmissions(std::size_t room) : room_(room) {}
  void set_room(std::size_t room) { room_ = room; }

  /// The transmission runs from now on.
  void start(Job& leader) { running_.push_back(&leader); }
  /// It does not run any more, but will be continued later.
  void leave(Job& leader);
  /// It is over. It must have no followers left.
  void end(Job& leader);
  /// The leader leaves, and the first follower leads instead. What was transmitted for the one
  /// counts for the other.
  void hand_over(Job& leader);

  /// In the order in which they were started.
  [[nodiscard]] std::span<Job* const> running() const { return running_; }
  /// The running one that has `on_wire` as its transaction on the wire.
  [[nodiscard]] Job& find(const Transaction* on_wire) const;
  /// Of those in flight, the one that was started first; nullptr if there is none.
  [[nodiscard]] Job* first_in_flight() const;
  /// The one in flight to the device at the address; nullptr if there is none.
  [[nodiscard]] const Job* in_flight_to(std::uint8_t address) const;
  [[nodiscard]] std::size_t in_flight() const;
  /// Its next try, or its next transaction, may go as far as the others are concerned. A stop goes
  /// beside what is already on the wire for its device; nothing more goes beside the stop.
  [[nodiscard]] bool may_go_on(const Job& running) const;
  [[nodiscard]] bool has_room() const { return in_flight() < room_; }
  [[nodiscard]] std::size_t room() const { return room_; }

 private:
  std::size_t room_;
  std::vector<Job*> running_;
};

}  // namespace mbgate::bus
