// SPDX-License-Identifier: Apache-2.0
// What must become of requests to a device that is certainly offline: one probe now and then, a
// small share of the time for all of them, everything else refused at once, and stops that keep
// nobody waiting.
#pragma once

#include "soak/asked.hpp"
#include "soak/flight.hpp"

namespace mbgate::soak {

class Oracle;
struct Lane;

class OfflineRules {
 public:
  explicit OfflineRules(Oracle& oracle) : oracle_(oracle) {}

  /// Of a transmission on a serial line, when it is known for whom it is. `before`: the one before
  /// it there, if any.
  void check(Flight& flight, const Flight* before) const;
  /// The device was not offline before its last transmission: what waited for it then has ended.
  void check_ended(std::size_t bus, const Lane& lane, const Flight& last) const;
  /// Its client was told that the device is offline, or that there is no answer.
  void judge_refused(const Asked& asked) const;
  /// Its client was told that there is no answer.
  void judge_wait(const Asked& asked) const;
  /// The status unit has shown a device's state.
  void judge_shown(const Asked& asked, const PduBytes& pdu) const;

 private:
  [[nodiscard]] bool may_be_probe(const Flight& flight, const Lane& lane) const;
  void check_probe(Flight& probe, const Lane& lane) const;
  void check_share(const Flight& probe) const;
  [[nodiscard]] bool somebody_waits(const Flight& probe) const;
  [[nodiscard]] Instant share_ends(std::size_t bus) const;
  [[nodiscard]] bool is_idle(std::size_t bus) const;
  [[nodiscard]] bool may_go_first(std::size_t bus, const Lane& other, const Lane& lane) const;
  [[nodiscard]] bool are_all_given_up(std::size_t bus, const Lane& lane) const;
  void check_stop(const Flight& stop, const Flight* before) const;
  void check_cut(const Flight& stop, const Flight* before) const;
  [[nodiscard]] bool is_cut_by(const Flight& stop, const Flight* before) const;
  [[nodiscard]] Instant waits_from(const Flight& stop) const;
  void check_room(const Flight& stop, const Flight* before) const;

  Oracle& oracle_;
};

}  // namespace mbgate::soak
