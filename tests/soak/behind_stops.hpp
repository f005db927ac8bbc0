// SPDX-License-Identifier: Apache-2.0
// What stops that let writes go first ask of these: none goes later, and all of them together hold
// the stop up for `stop_wait` at most while they wait for something themselves.
#pragma once

#include "soak/asked.hpp"
#include "soak/flight.hpp"

namespace mbgate::soak {

class Oracle;

class BehindStops {
 public:
  explicit BehindStops(Oracle& oracle) : oracle_(oracle) {}

  /// `alone`: the transmission is surely for this request.
  void check(const Asked& asked, const Flight& flight, bool alone) const;
  /// The client of a stop was told that it is done.
  void note_done(const Asked& asked) const;
  /// A write that nobody has cancelled was answered 06.
  void judge_not_sent(const Asked& write) const;
  /// `free`: since then nothing on the line itself has held the transmission up.
  void note_held(const Flight& flight, Instant free) const;

 private:
  Oracle& oracle_;
};

}  // namespace mbgate::soak
