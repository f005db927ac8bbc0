// SPDX-License-Identifier: Apache-2.0
// Ends jobs; no other class does. The owner of a job gets a JobEnded.
#pragma once

#include <optional>

#include "bus/parts.hpp"

namespace mbgate::bus {

class JobEnds {
 public:
  explicit JobEnds(Parts& parts) : parts_(parts) {}

  void end(Job& job, Ending ending);
  /// The bus gives the job up, without a JobEnded.
  void release(Job& job);
  /// A transmission is over: ends the jobs that share it, then its leader. Jobs that share a stop
  /// get its responses.
  void finish(Job& job, Ending ending);
  /// The current transaction is over: the next one follows or, if none is left, the transmission is
  /// finished with `ending`.
  void advance(Job& job, Ending ending);

  /// Ends waiting jobs whose deadline has passed.
  void expire(Instant now);
  /// Ends running jobs that are not on the wire and of which nothing more is to be sent.
  void end_over(Instant now);
  void end_running(Ending ending);
  /// Ends the jobs that wait, stops excepted.
  void end_waiting(Ending ending);
  /// Ends the stops that wait.
  void end_stops(Ending ending);
  /// The device at the address is offline: ends the jobs that wait for it.
  void end_waiting_for(std::uint8_t address);
  /// Ends writes that were to be repeated and no longer may be.
  void end_repeats();
  /// Cancels the writes that the stop forbids. One that is not on the wire is never transmitted; of
  /// one that is, no further transaction is.
  void overtake_writes(const Job& stop);

 private:
  template <typename Predicate>
  void end_queued(Predicate is_one, Ending ending, std::uint64_t& count);
  [[nodiscard]] std::optional<Ending> over(const Job& job, const Job& running, Instant now) const;
  void drop_followers(Job& job, Instant now);

  Parts& parts_;
};

}  // namespace mbgate::bus
