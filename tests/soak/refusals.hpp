// SPDX-License-Identifier: Apache-2.0
// Why the gateway answered 06, 0A or 0B by itself: the fault that this very request met. What met
// none is a violation; the reasons are counted in the report.
#pragma once

#include <cstdint>

#include "soak/asked.hpp"
#include "soak/flight.hpp"

namespace mbgate::soak {

class Oracle;

class Refusals {
 public:
  explicit Refusals(Oracle& oracle) : oracle_(oracle) {}

  /// The server device is busy (06): it was never transmitted.
  void judge_busy(const Asked& asked) const;
  /// There is no path (0A): it was never transmitted.
  void judge_no_path(const Asked& asked) const;
  /// The device did not answer (0B): it was transmitted, or reads a device that is offline.
  void judge_no_response(const Asked& asked) const;
  /// Its drive has refused a stop.
  void judge_refused_stop(const Asked& stop, std::uint8_t code) const;

 private:
  /// Reasons are names; nullptr: there is none.
  [[nodiscard]] const char* why_busy(const Asked& asked) const;
  [[nodiscard]] bool goes_at_the_end(const Asked& asked) const;
  [[nodiscard]] const char* why_withdrawn(const Asked& asked) const;
  [[nodiscard]] const char* why_no_path(const Asked& asked) const;
  [[nodiscard]] const char* why_no_response(const Asked& asked) const;
  void judge_tries(const Asked& stop) const;
  [[nodiscard]] const char* why_unfinished(const Asked& asked) const;
  [[nodiscard]] bool was_merged(const Asked& asked) const;
  [[nodiscard]] const char* fault_of(const Asked& asked) const;
  [[nodiscard]] const char* fault_of(const Flight& flight) const;
  [[nodiscard]] const char* end_of_wait(const Flight& flight) const;
  [[nodiscard]] bool may_be_cut(const Flight& flight) const;
  [[nodiscard]] bool has_expired(const Asked& asked) const;
  [[nodiscard]] bool found_no_room(const Asked& asked, std::size_t bus) const;
  [[nodiscard]] bool was_cut_short(const Asked& broadcast) const;
  [[nodiscard]] bool found_no_path(const Asked& broadcast) const;
  [[nodiscard]] bool is_away(const Asked& asked) const;
  void note(const char* code, const char* reason) const;

  Oracle& oracle_;
};

}  // namespace mbgate::soak
