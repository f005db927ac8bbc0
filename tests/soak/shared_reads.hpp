// SPDX-License-Identifier: Apache-2.0
// Reads that are sent once for several clients: how long they may be, how often they are tried, and
// what follows if they fail.
#pragma once

#include <utility>
#include <vector>

#include "soak/flight.hpp"

namespace mbgate::soak {

class Oracle;
struct Book;

class SharedReads {
 public:
  /// Requests that a transmission may be for, each with the part that it fits.
  using Meant = std::vector<std::pair<Asked*, Piece*>>;
  explicit SharedReads(Oracle& oracle) : oracle_(oracle) {}

  void check_bounds(const Flight& flight) const;
  /// To be called before it is noted for whom the flight is.
  void count_tries(Flight& flight, const Meant& meant) const;
  /// The same: which writes wait while it is transmitted for several, and whether it surely is for
  /// each of these.
  void note_writes(Flight& flight, const Meant& meant) const;
  /// The broadcast is transmitted: no read that its client address asked for before waits.
  void check_overtaken(const Asked& broadcast, const Flight& flight) const;
  /// A read has got its data.
  void judge_joined(const Asked& asked) const;

 private:
  [[nodiscard]] const Flight* last_like(const Flight& flight, const Meant& meant) const;
  [[nodiscard]] bool is_for_each(const Flight& flight, const Meant& meant) const;
  [[nodiscard]] bool joins_for_certain(const Asked& asked, const Flight& flight,
                                       const Meant& meant) const;
  [[nodiscard]] bool surely_waits_before(const Asked& read, const Asked& broadcast,
                                         const Book& book) const;
  [[nodiscard]] bool surely_waits(const Asked& write, std::size_t bus) const;

  Oracle& oracle_;
};

}  // namespace mbgate::soak
