// SPDX-License-Identifier: Apache-2.0
// How often rules may permit something to a host, as far as it can be told from outside: so many
// requests at once as the rate says, then one after the other; a reload begins to count anew.
#pragma once

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "soak/asked.hpp"

namespace mbgate::soak {

class RuleRates {
 public:
  explicit RuleRates(const SoakPlan& plan) : plan_(plan) {}

  /// The gateway has accepted it, and has let it through, or refuses it at once.
  void accepted(const Asked& asked, Instant now);
  /// Is it refused because of a rate? Then it counts for none.
  [[nodiscard]] bool is_refused(const Asked& asked, Instant now);
  /// It was surely let through. A rule that has let too many through; nothing if none has.
  [[nodiscard]] std::string let_through(const Asked& asked);
  /// It was answered, or its client has gone; `now` and some lateness later it is not accepted.
  void closed(const Asked& asked, Instant now, Duration lateness);
  void after_reload(Instant now);

 private:
  struct Passed {
    std::uint64_t id;
    std::uint64_t client;
    std::uint64_t sequence;
    Instant at;      ///< accepted, at the earliest
    Instant latest;  ///< accepted, at the latest
    bool is_open = true;
    bool surely = false;  ///< let through

    [[nodiscard]] bool is_unsure() const { return latest > at; }
  };
  /// Of a rule and a host.
  struct Counted {
    std::vector<Passed> passed;  ///< in the order of acceptance
    // What those have left behind that are not in it any more:
    Instant perhaps_until = Instant::min();
    Instant surely_until = Instant::min();
  };
  using Key = std::pair<std::size_t, unsigned>;  // rule and host
  [[nodiscard]] Duration every(const Key& key) const;
  [[nodiscard]] bool may_be_over(const Key& key, const Passed& asked) const;
  void forget_old(const Key& key, Instant now);

  const SoakPlan& plan_;
  std::map<Key, Counted> counted_;
  std::set<std::uint64_t> were_over_;  // perhaps, by what counted before a reload
};

}  // namespace mbgate::soak
