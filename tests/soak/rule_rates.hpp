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
  void after_reload();

 private:
  struct Passed {
    std::uint64_t id;
    std::uint64_t client;
    std::uint64_t sequence;
    Instant at;
    bool unsure = false;  ///< it was perhaps accepted later
    bool surely = false;  ///< let through
  };
  using Key = std::pair<std::size_t, unsigned>;  // rule and host
  [[nodiscard]] Duration every(const Key& key) const;
  [[nodiscard]] bool may_be_over(const Key& key, const Passed& asked) const;

  const SoakPlan& plan_;
  std::map<Key, std::vector<Passed>> passed_;  // in the order of acceptance
  std::set<std::uint64_t> were_over_;          // perhaps, by what counted before a reload
};

}  // namespace mbgate::soak
