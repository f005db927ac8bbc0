// SPDX-License-Identifier: Apache-2.0
// What the access rules must remember of clients: how often a rule has let one through lately, and
// of which denials the journal was told. Without rules it holds nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>

#include "bus/state_reader.hpp"
#include "gateway/access/rule_verdict.hpp"
#include "gateway/second_rate.hpp"

namespace mbgate::gateway {

class AccessBook {
 public:
  /// A request that the verdict permits is let through, unless the client's address is over the
  /// rate of a rule: then false. `rate = "10/s"` lets ten through at once, and then one every 100
  /// ms.
  [[nodiscard]] bool take(const RuleVerdict& verdict, const routing::ClientAddress& client,
                          Instant now);
  /// A request was denied. Nothing if the journal was told of this client within a minute; else
  /// how many of its requests were denied since then, without this one.
  [[nodiscard]] std::optional<std::uint64_t> note_denied(const routing::ClientAddress& client,
                                                         Instant now);
  /// Other rules are in force: what the old ones have let through does not count.
  void forget_rates() { rates_.clear(); }

 private:
  friend struct mbgate::StateReader;
  using Key = std::pair<const routing::AccessRule*, routing::ClientAddress>;
  struct Told {
    Instant at;
    std::uint64_t left_out = 0;
  };
  [[nodiscard]] bool has_room(const routing::AccessRule* rule, const routing::ClientAddress& client,
                              Instant now);
  void count(const routing::AccessRule* rule, const routing::ClientAddress& client, Instant now);

  std::map<Key, SecondRate> rates_;
  std::map<routing::ClientAddress, Told> told_;
};

}  // namespace mbgate::gateway
