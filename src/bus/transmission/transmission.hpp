// SPDX-License-Identifier: Apache-2.0
// What is on the wire for one or several jobs, or was and will be again. Jobs that ask for the same
// at the same time share a transmission: one leads, and its transaction is what is transmitted; the
// others follow, and get the answer too.
#pragma once

#include <boost/container/small_vector.hpp>
#include <boost/intrusive/list_hook.hpp>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "bus/job.hpp"
#include "bus/state_reader.hpp"

namespace mbgate::bus {

struct Transmission {
  boost::intrusive::list_member_hook<> stop_hook;  ///< of the stop lane
  Job* leader = nullptr;
  boost::container::small_vector<Job*, 1> followers;
  std::unique_ptr<Transaction> merged;  ///< what is transmitted instead, for all of them
  unsigned tries = 0;                   ///< transmissions of the leader's current transaction
  /// The transaction that is asked once more because a connection was closed before its answer.
  std::optional<std::size_t> cut;
  bool in_flight = false;   ///< it was transmitted, and has not ended
  bool is_probe = false;    ///< lets the bus know whether an offline device answers again
  bool is_one_try = false;  ///< a stop that is not repeated, because its device is given up
  bool is_let_by = false;   ///< it goes between two tries of a stop
  Instant waits_since;      ///< of a stop: accepted then, or repeated
  /// Of a stop: for so long the writes were held back that it let go first.
  Duration held_by_writes{0};
  Instant transmitted_at;           ///< the current transaction, for the first time
  Instant last_sent;                ///< the last transmission of anything of it
  std::uint64_t turn = 0;           ///< which transmission of its bus that was
  std::uint64_t writes_before = 0;  ///< to its device, ended before it was transmitted

  [[nodiscard]] Transaction& on_wire() const { return merged ? *merged : leader->transaction(); }
  [[nodiscard]] bool is_stop() const { return leader->job_class == JobClass::stop; }
  /// It has one transaction, which is to be repeated.
  [[nodiscard]] bool is_between_tries() const {
    return tries > 0 && !in_flight && leader->transactions.size() == 1;
  }
};

/// Is the job's current transaction on the wire, with the job as the one that leads?
[[nodiscard]] inline bool is_in_flight(const Job& job) {
  return job.leads != nullptr && job.leads->in_flight;
}

/// The transmissions of a bus. They run from when they first go on the wire until they are over,
/// between two tries and between the parts of a job too; stops wait in their lane before and
/// between.
class Transmissions {
 public:
  /// So many may be in flight at the same time.
  explicit Transmissions(std::size_t room) : room_(room) {}
  void set_room(std::size_t room) { room_ = room; }

  /// One that does not run yet. It has a stable address until it is over.
  Transmission& lead(Job& leader);
  /// It runs from now on.
  void start(Transmission& transmission);
  /// It does not run any more, but goes on later.
  void leave(Transmission& transmission);
  /// It is over: its leader leads nothing. Its followers must have gone.
  void end(Transmission& transmission);
  /// The leader goes, and the first follower leads: what was transmitted for the one was for the
  /// other.
  static void hand_over(Transmission& transmission);

  /// In the order in which they were started.
  [[nodiscard]] std::span<Transmission* const> running() const { return running_; }
  [[nodiscard]] Transmission& find(const Transaction* on_wire) const;
  /// Of those in flight the one that was started first.
  [[nodiscard]] Transmission* first_in_flight() const;
  [[nodiscard]] bool has_room() const { return in_flight() < room_; }
  [[nodiscard]] std::size_t room() const { return room_; }

 private:
  friend struct mbgate::StateReader;
  [[nodiscard]] std::size_t in_flight() const;

  std::size_t room_;
  std::vector<Transmission*> running_;
  std::deque<Transmission> all_;  // a deque because its elements have a stable address
  std::vector<Transmission*> free_;
};

}  // namespace mbgate::bus
