// SPDX-License-Identifier: Apache-2.0
// What becomes of a request before it waits: it is refused, answered at once, or queued.
#pragma once

#include <optional>

#include "bus/parts.hpp"
#include "bus/transmission/job_ends.hpp"

namespace mbgate::bus {

/// What has become of a request.
enum class Admitted : std::uint8_t {
  waits,
  ended,   ///< it needed no transmission, or may not have one
  refused  ///< the queue is full, and the bus does not have the job
};

class Admission {
 public:
  Admission(Parts& parts, JobEnds& ends) : parts_(parts), ends_(ends) {}

  [[nodiscard]] Admitted admit(Job& job, Instant now);

 private:
  void classify(Job& job) const;
  [[nodiscard]] bool is_stop(const Job& job) const;
  std::optional<Ending> end_at_once(Job& job, Instant now);
  bool take_cached(Job& job, Instant now);
  bool push(Job& job);
  bool push_stop(Job& job);

  Parts& parts_;
  JobEnds& ends_;
  std::uint64_t sequence_ = 0;  // of the job that was accepted last
};

}  // namespace mbgate::bus
