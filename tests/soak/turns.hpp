// SPDX-License-Identifier: Apache-2.0
// Who goes first on a serial line: writes before reads, after `burst` of them a read, and client
// addresses in turn, by their weights. Judged only where nothing but the turn could decide: all
// that was transmitted was answered or expects no answer, nothing is to be repeated, and no stop or
// broadcast waits.
#pragma once

#include <bitset>
#include <map>
#include <optional>
#include <vector>

#include "soak/asked.hpp"
#include "soak/flight.hpp"

namespace mbgate::soak {

class Oracle;
struct Lane;

/// What went over a line lately.
struct Turns {
  unsigned writes = 0;                             ///< in a row, surely
  unsigned most_writes = 0;                        ///< the same at most
  std::map<unsigned, std::vector<Instant>> reads;  ///< of each client address since it was unclear
  std::map<unsigned, Instant> last;                ///< turn of each
  /// Turns that a client address has had since nothing of it waited here; absent if nobody knows.
  std::map<unsigned, unsigned> since_empty;
  std::optional<unsigned> reader;         ///< whose read went last, if that was clear
  Instant read_at;                        ///< when
  std::vector<std::uint64_t> came_after;  ///< reads of others that could have gone then
};

class TurnRules {
 public:
  explicit TurnRules(Oracle& oracle) : oracle_(oracle) {}

  /// To be called when it is known for whom it is, and before it counts.
  void check(const Flight& flight) const;
  /// The read is repeated and its last try, which was the last transmission, left unanswered.
  void check_repeat(const Flight& read, const Flight& before) const;
  /// Nothing on the line held anything up since `free`: what could go has gone within `lateness`.
  void check_idle(const Flight& flight, Instant free, Duration lateness) const;
  /// Something is on the wire for its device besides this transmission, or may be.
  [[nodiscard]] bool is_in_use(std::uint8_t address, const Flight& beside) const;
  /// A request to another device that could have gone since then; none if nobody can tell.
  [[nodiscard]] const Asked* waiting_for_room(const Flight& stop, Instant since) const;

 private:
  static constexpr Duration kLongestGap = std::chrono::seconds(1);  ///< longer than plans draw

  [[nodiscard]] std::optional<std::bitset<256>> turns_taken(const Flight& read,
                                                            const Flight& before) const;
  [[nodiscard]] const Asked* only_one(const Flight& flight) const;
  [[nodiscard]] bool is_clear(const Flight& flight) const;
  /// `most_gap`: those to devices with a gap too, up to so long a one.
  [[nodiscard]] std::vector<const Asked*> others_that_may_go(const Flight& flight,
                                                             Duration most_gap = Duration{0}) const;
  [[nodiscard]] static bool waits_for_its_turn(const Asked& asked, const Flight& flight);
  [[nodiscard]] bool may_go(const Asked& asked, const Lane& lane, const Flight& flight,
                            Duration most_gap) const;
  [[nodiscard]] Duration gap_at(const Lane& lane) const;
  [[nodiscard]] unsigned weight_of(unsigned host) const;
  void judge(const Flight& flight, const Asked& asked, const Turns& turns) const;
  void judge_weight(const Asked& read, const Turns& turns,
                    const std::vector<const Asked*>& others) const;
  void count(const Flight& flight, const Asked& asked, Turns& turns) const;
  void note_reader(const Flight& flight, const Asked& asked, Turns& turns) const;
  void note_empty(const Flight& flight, Turns& turns) const;
  void judge_reads(const Flight& flight, const Asked& read, const Turns& turns,
                   const std::vector<const Asked*>& others) const;

  Oracle& oracle_;
};

}  // namespace mbgate::soak
