// SPDX-License-Identifier: Apache-2.0
// A frame that is on the wire for one or several jobs, or is about to be sent again. Jobs with the
// same request at the same time share a transmission. One of them leads: its transaction is
// transmitted. The others follow and get the same answer.
#pragma once

#include <boost/container/small_vector.hpp>
#include <boost/intrusive/list_hook.hpp>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "bus/bus_action.hpp"
#include "bus/job.hpp"

namespace mbgate::bus {

struct Transmission {
  boost::intrusive::list_member_hook<> stop_hook;  ///< of the stop lane
  Job* leader = nullptr;
  boost::container::small_vector<Job*, 1> followers;
  unsigned tries = 0;  ///< transmissions of the leader's current transaction
  /// The transaction that is sent once more because the connection was closed before its answer.
  std::optional<std::size_t> cut;
  bool in_flight = false;   ///< it was transmitted, and has not ended
  bool is_probe = false;    ///< tests whether an offline device answers again
  bool is_one_try = false;  ///< a stop that is not repeated, because an earlier one was given up
  Duration hurried_by{0};   ///< its wait is shorter by this, as the device may not be there
  Instant waits_since;      ///< of a stop: accepted then, or repeated
  Instant transmitted_at;   ///< the first time of the current transaction
  Instant last_sent;        ///< the last time of any of its transactions
  std::uint64_t writes_before = 0;  ///< writes to its device that ended before it was sent

  [[nodiscard]] Transaction& on_wire() const { return leader->transaction(); }
  [[nodiscard]] bool is_stop() const { return leader->job_class == JobClass::stop; }
  /// Nobody wants it sent any more.
  [[nodiscard]] bool is_abandoned() const {
    return leader->abandoned && std::ranges::all_of(followers, &Job::abandoned);
  }
  /// It has a single transaction, which is to be repeated.
  [[nodiscard]] bool is_between_tries() const {
    return tries > 0 && !in_flight && leader->transactions.size() == 1;
  }
  /// From then on nothing is sent for this job, which leads or follows. If a part of it was done,
  /// it may be finished after its deadline, a read within five seconds, but nothing is repeated.
  /// The forms of a broadcast are no parts, nor are checks (must_hold).
  [[nodiscard]] Instant ends_at(const Job& job) const {
    const auto is_part = [](const Transaction& it) { return it.must_hold == nullptr; };
    const bool is_begun =
        tries == 0 && !leader->is_broadcast() &&
        std::ranges::any_of(std::span(leader->transactions).first(leader->current), is_part);
    constexpr auto kToFinish = std::chrono::seconds(5);
    return !is_begun ? job.deadline : job.is_read() ? job.deadline + kToFinish : Instant::max();
  }
};

/// For whom it is, for a trace.
[[nodiscard]] TransmissionTitle title_of(const Transmission& transmission);

/// Is the job's current transaction on the wire, with the job as its leader?
[[nodiscard]] inline bool is_in_flight(const Job& job) {
  return job.leads != nullptr && job.leads->in_flight;
}

/// The transmissions of a bus. A transmission runs from its first frame on the wire until it is
/// over, also between two tries and between the transactions of a job. A stop waits in the stop
/// lane before its first try and between its tries.
class Transmissions {
 public:
  /// `room`: the most that may be in flight at the same time.
  explicit Transmissions(std::size_t room) : room_(room) {}
  void set_room(std::size_t room) { room_ = room; }

  /// A new transmission that does not run yet. It has a stable address until end().
  Transmission& lead(Job& leader);
  /// The transmission runs from now on.
  void start(Transmission& transmission);
  /// It does not run any more, but will be continued later.
  void leave(Transmission& transmission);
  /// It is over, and its leader no longer leads. It must have no followers left.
  void end(Transmission& transmission);
  /// The leader leaves, and the first follower leads instead. What was transmitted for the one
  /// counts for the other.
  static void hand_over(Transmission& transmission);

  /// In the order in which they were started.
  [[nodiscard]] std::span<Transmission* const> running() const { return running_; }
  /// The running one that has `on_wire` as its transaction on the wire.
  [[nodiscard]] Transmission& find(const Transaction* on_wire) const;
  /// Of those in flight, the one that was started first; nullptr if there is none.
  [[nodiscard]] Transmission* first_in_flight() const;
  /// The one in flight to the device at the address; nullptr if there is none.
  [[nodiscard]] const Transmission* in_flight_to(std::uint8_t address) const;
  [[nodiscard]] std::size_t in_flight() const;
  /// Its next try, or its next transaction, may go as far as the others are concerned. A stop goes
  /// beside what is already on the wire for its device; nothing more goes beside the stop.
  [[nodiscard]] bool may_go_on(const Transmission& running) const;
  [[nodiscard]] bool has_room() const { return in_flight() < room_; }
  [[nodiscard]] std::size_t room() const { return room_; }

 private:
  std::size_t room_;
  std::vector<Transmission*> running_;
  std::deque<Transmission> all_;  // a deque because its elements have a stable address
  std::vector<Transmission*> free_;
};

}  // namespace mbgate::bus
