// SPDX-License-Identifier: Apache-2.0
// The requests waiting for a bus: client addresses take turns, and each address's requests to one
// device stay in order. Bounded; allocates only when a client address is seen for the first time.
#pragma once

#include <bitset>
#include <boost/intrusive/list.hpp>
#include <boost/intrusive/set.hpp>
#include <deque>

#include "bus/device_table.hpp"
#include "bus/job.hpp"

namespace mbgate::bus {

class BusQueue {
 public:
  explicit BusQueue(std::size_t limit) : limit_(limit) {}

  /// False if the queue is full; the job is then untouched.
  bool push(Job& job);
  /// Shows `visit` the jobs that may go next, in the order of their turns: of each client address
  /// the oldest to each device. A broadcast is for every device: nothing of its client address
  /// overtakes it, and it overtakes nothing. Ends when `visit` returns true; the queue must not be
  /// changed before.
  template <typename Visit>
  void visit_candidates(Visit visit);
  /// Takes a job whose turn it is; its client address goes to the back of the round.
  void take(Job& job);
  /// Takes any waiting job out.
  void remove(Job& job);
  /// The waiting job whose deadline comes first, or nothing.
  [[nodiscard]] Job* first_to_expire();
  [[nodiscard]] std::optional<Instant> first_deadline() const;
  [[nodiscard]] std::size_t size() const { return by_deadline_.size(); }

 private:
  using JobList = boost::intrusive::list<
      Job,
      boost::intrusive::member_hook<Job, boost::intrusive::list_member_hook<>, &Job::queue_hook>>;
  struct ByDeadline {
    bool operator()(const Job& a, const Job& b) const { return a.deadline < b.deadline; }
  };
  using DeadlineSet = boost::intrusive::multiset<
      Job, boost::intrusive::compare<ByDeadline>,
      boost::intrusive::member_hook<Job, boost::intrusive::set_member_hook<>, &Job::deadline_hook>>;
  struct Source {
    boost::intrusive::list_member_hook<> round_hook;
    JobList waiting;
  };
  using Round = boost::intrusive::list<
      Source, boost::intrusive::member_hook<Source, boost::intrusive::list_member_hook<>,
                                            &Source::round_hook>>;

  Source& source_of(const Job& job) { return sources_[static_cast<std::size_t>(job.source)]; }
  template <typename Visit>
  static bool visit_source(Source& source, Visit& visit);

  std::size_t limit_;
  std::deque<Source> sources_;  // by SourceId; a deque because its elements lie still
  Round round_;                 // sources that have jobs waiting
  DeadlineSet by_deadline_;
};

template <typename Visit>
void BusQueue::visit_candidates(Visit visit) {
  for (Source& source : round_) {
    if (visit_source(source, visit)) {
      return;
    }
  }
}

template <typename Visit>
bool BusQueue::visit_source(Source& source, Visit& visit) {
  std::bitset<kAddresses> seen;
  for (Job& job : source.waiting) {
    const Transaction& first = job.transactions.front();
    if (job.is_broadcast()) {
      return seen.none() && visit(job);
    }
    if (!seen[first.address]) {
      seen.set(first.address);
      if (visit(job)) {
        return true;
      }
    }
  }
  return false;
}

}  // namespace mbgate::bus
