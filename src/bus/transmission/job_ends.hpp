// SPDX-License-Identifier: Apache-2.0
// How jobs end: the only place where they do. Whoever submitted one is told by a JobEnded.
#pragma once

#include <optional>
#include <vector>

#include "bus/parts.hpp"

namespace mbgate::bus {

class JobEnds {
 public:
  explicit JobEnds(Parts& parts) : parts_(parts) {}

  void end(Job& job, Ending ending);
  /// The bus has it no more, and nobody is told.
  void release(Job& job);
  /// A transmission is over: its leader ends, and before it those that share it. Stops share its
  /// responses too.
  void finish(Transmission& transmission, Ending ending);
  /// The current transaction is over: the next one follows, or none is left.
  void advance(Transmission& transmission, Ending ending);
  /// A merged read failed: its parts are sent one by one, before what their clients asked for
  /// later. Who asked for all of it himself has had his tries.
  void split_up(Transmission& transmission, Ending how);

  /// Those that wait, and whose deadline is over.
  void expire(Instant now);
  /// Those that run, are not on the wire, and of which nothing more is to be transmitted.
  void end_over(Instant now);
  void end_running(Ending ending);
  void end_waiting(Ending ending, bool stops_too);
  /// A device is offline: those that wait for it.
  void end_waiting_for(std::uint8_t address);
  /// Somebody else asks now: what waits for offline devices must not be in the way.
  void end_free_probes(Instant now);
  /// Writes that were to be repeated, and may not be any more.
  void end_repeats();
  /// Writes that the stop forbids and that are not on the wire are never transmitted; of one that
  /// is, no further part is.
  void overtake_writes(const Job& stop);
  /// The same for those that it let go first.
  void overtake_writes_before(const Job& stop);

 private:
  template <typename Predicate>
  void end_queued(Predicate is_one, Ending ending, std::uint64_t& count);
  template <typename Predicate>
  void overtake(Predicate is_overtaken);
  [[nodiscard]] std::optional<Ending> over(const Job& job, Instant now) const;
  void drop_followers(Transmission& transmission, Instant now);

  Parts& parts_;
};

}  // namespace mbgate::bus
