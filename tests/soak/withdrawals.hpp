// SPDX-License-Identifier: Apache-2.0
// What stops take back: writes to the same device that came before and are not on the wire yet,
// wherever they wait; and what a reload does to requests that are not accepted yet.
#pragma once

#include <deque>
#include <vector>

#include "soak/asked.hpp"

namespace mbgate::soak {

struct Lane;
struct Session;
class Oracle;

class Withdrawals {
 public:
  explicit Withdrawals(Oracle& oracle) : oracle_(oracle) {}

  void take_back_for(const Asked& stop) const;
  /// By now the gateway has surely taken it: one that had to wait for room perhaps only now.
  void note_taken(const Asked& stop) const;
  /// It may have been taken back, or be so now.
  [[nodiscard]] bool may_be_stopped(const Asked& write) const;
  /// It let the writes before it go, and does so no longer.
  void take_back_for_waiting(const Asked& stop) const;
  /// It turns out to be older than the settings that made it a stop.
  void give_back(const Asked& stop) const;
  /// The writes that lie in front of it and that it lets go first.
  [[nodiscard]] std::vector<Asked*> held_by(const std::deque<std::uint64_t>& backlog,
                                            const Asked& stop) const;
  /// It was transmitted although these lie in front of it: they must be outdated.
  void note_passed(const Asked& stop) const;
  /// What lies in front of a stop that lets it go first is not held up, however much its host asks.
  void let_pass(const Session& session, const Asked& stop) const;
  /// A reload has given units another meaning.
  void refuse_outdated() const;
  /// It counts as having come at `came`: perhaps before a reload.
  void refuse_outdated(Asked& asked, Instant came) const;
  /// Of a request that is refused anyway: it may have been withdrawn before that was seen.
  [[nodiscard]] bool may_come_before(const Asked& refused, std::uint8_t code) const;
  [[nodiscard]] bool is_older_broadcast(const Asked& asked) const;

 private:
  void note_stop(const Asked& stop) const;
  [[nodiscard]] std::vector<Lane*> stopped_by(const Asked& stop, const Piece& piece) const;
  void take_back_writes(const Lane& lane) const;
  void take_back_broadcasts(const Asked& stop, std::size_t bus) const;
  void take_back_read_ahead(const Asked& stop) const;
  [[nodiscard]] bool stops_at(const Asked& stop, std::size_t bus, std::size_t address) const;
  [[nodiscard]] std::uint8_t form_of(std::size_t device) const;
  [[nodiscard]] bool reaches(const Asked& stop, std::size_t bus, std::uint8_t form) const;
  [[nodiscard]] bool is_for(const Asked& stop, const Asked& write) const;

  Oracle& oracle_;
};

}  // namespace mbgate::soak
