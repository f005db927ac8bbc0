// SPDX-License-Identifier: Apache-2.0
// Remembers for rules with a rate how many requests of each client they have permitted lately.
// Without rules it holds nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>

#include "gateway/access/rule_verdict.hpp"
#include "gateway/second_rate.hpp"

namespace mbgate::gateway {

class AccessBook {
 public:
  /// A request that the verdict permits is let through, unless the client is over the
  /// rate of a rule: then false. `rate = "10/s"` lets ten through at once, and then one every 100
  /// ms.
  [[nodiscard]] bool take(const RuleVerdict& verdict, const ClientKey& client, Instant now);
  /// Other rules are in force: what the old ones have let through does not count.
  void forget_rates() { rates_.clear(); }

 private:
  using Key = std::pair<const routing::AccessRule*, ClientKey>;
  [[nodiscard]] bool has_room(const routing::AccessRule* rule, const ClientKey& client,
                              Instant now);
  void count(const routing::AccessRule* rule, const ClientKey& client, Instant now);

  std::map<Key, SecondRate> rates_;
};

}  // namespace mbgate::gateway
