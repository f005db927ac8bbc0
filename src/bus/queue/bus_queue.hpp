// SPDX-License-Identifier: Apache-2.0
// The reads and writes waiting for a bus. Client addresses take turns by their weight; the requests
// of one address to one device stay in order. Stops wait in a lane of their own. Bounded; allocates
// only when a client address is seen for the first time.
#pragma once

#include <algorithm>
#include <bitset>
#include <boost/intrusive/list.hpp>
#include <boost/intrusive/set.hpp>
#include <memory>
#include <utility>
#include <vector>

#include "bus/health/device_table.hpp"
#include "bus/job.hpp"

namespace mbgate::bus {

class BusQueue {
 public:
  explicit BusQueue(std::size_t limit) : limit_(limit) {}
  void set_limit(std::size_t limit) { limit_ = limit; }

  /// Queues a job behind those of its client address. False if there is no room; the job is then
  /// untouched.
  bool push(Job& job);
  /// The waiting read that has to make room in a full queue: the newest of the client address with
  /// the most waiting requests. Nothing if that one has no read that waits.
  [[nodiscard]] Job* read_to_evict();

  /// Calls `visit` for the jobs of the class that may be sent next, in the order of their turns:
  /// for each client address the oldest job to each device, if it is of that class. A broadcast
  /// goes to every device: no job of its client address overtakes it, and it overtakes none. Ends
  /// when `visit` returns true; the queue must not be changed before.
  template <typename Visit>
  void visit_candidates(JobClass job_class, Visit visit) {
    const std::size_t reads = by_deadline_.size() - writes_;
    if ((job_class == JobClass::write ? writes_ : reads) == 0) {
      return;  // nobody needs to look at hundreds of reads to find no write
    }
    for (Source& source : round_) {
      if (visit_source(source, job_class, visit)) {
        return;
      }
    }
  }
  /// For each client address calls `visit` for its waiting jobs to the device, in order, until it
  /// returns false or a broadcast comes.
  template <typename Visit>
  void visit_fronts(std::uint8_t address, Visit visit) {
    for (Source& source : round_) {
      for (Job& job : source.waiting) {
        if (job.is_broadcast() || (job.address() == address && !visit(job))) {
          break;
        }
      }
    }
  }
  /// Calls `visit` for every waiting job.
  template <typename Visit>
  void visit_all(Visit visit) {
    for (Source& source : round_) {
      std::ranges::for_each(source.waiting, visit);
    }
  }
  /// Of the waiting writes to the device, broadcasts among them: when the last one was accepted
  /// before this place in the order of acceptance, and when the first one behind it.
  [[nodiscard]] std::pair<std::uint64_t, std::uint64_t> writes_around(std::uint8_t address,
                                                                      std::uint64_t sequence);

  /// Removes a job whose turn it is; its client address has one turn less.
  void take(Job& job);
  /// Removes any waiting job; this costs no turn.
  void remove(Job& job);
  /// The waiting job whose deadline comes first, or nothing.
  [[nodiscard]] Job* first_to_expire();
  [[nodiscard]] std::optional<Instant> first_deadline() const;
  [[nodiscard]] std::size_t size() const { return by_deadline_.size(); }
  /// How long the job has waited that waits longest.
  [[nodiscard]] Duration longest_wait(Instant now) const;
  /// The client address with the most waiting requests.
  struct Most {
    FairnessKey source{};
    std::size_t requests = 0;
    std::size_t of = 0;  ///< waiting requests of all client addresses
    Instant since;       ///< its first one was accepted
  };
  /// Requests for the addresses that are held back do not count: the line is not what they wait
  /// for.
  [[nodiscard]] std::optional<Most> most_waiting(const Addresses& held_back) const;

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
    unsigned weight = 1;
    unsigned turns = 1;  // left before it moves to the back of the round
  };
  using Round = boost::intrusive::list<
      Source, boost::intrusive::member_hook<Source, boost::intrusive::list_member_hook<>,
                                            &Source::round_hook>>;

  Source& source_of(const Job& job);
  template <typename Visit>
  static bool visit_source(Source& source, JobClass job_class, Visit& visit) {
    std::bitset<kAddresses> seen;
    for (Job& job : source.waiting) {
      if (job.is_broadcast()) {
        return seen.none() && job.job_class == job_class && visit(job);
      }
      if (!seen[job.address()]) {
        seen.set(job.address());
        if (job.job_class == job_class && visit(job)) {
          return true;
        }
      }
    }
    return false;
  }

  std::size_t limit_;
  std::vector<std::unique_ptr<Source>> sources_;  // by FairnessKey
  Round round_;                                   // sources with waiting jobs
  DeadlineSet by_deadline_;
  std::size_t writes_ = 0;  // of these
};

}  // namespace mbgate::bus
