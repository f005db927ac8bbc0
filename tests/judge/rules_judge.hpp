// SPDX-License-Identifier: Apache-2.0
// Truths of what is configured for clients and not of lines: rights, writers, rates, the order of
// answers, counters (behaviour.md, sections 2, 3 and 8). It tells the judge of lines what it sees.
#pragma once

#include <deque>
#include <map>

#include "world/world.hpp"

namespace mbgate::judge {

using namespace world;  // NOLINT(google-build-using-namespace): it is about nothing else

class RulesJudge : public Witness {
 public:
  RulesJudge(World& world, Witness& next)
      : world_(world),
        next_(next),
        plan_(world.plan()),
        ledger_(world.ledger()),
        report_(world.report()) {}

  void asked(Id asked) override { next_.asked(asked); }
  void given(Id asked) override;
  void answered(Id asked) override;
  void sent(Id sent) override;
  void came(std::size_t bus) override { next_.came(bus); }
  void gone(Id connection) override { next_.gone(connection); }

 private:
  // truth_rights.cpp
  void check_denied(const Asked& asked);
  void check_withdrawn(const Sent& sent);

  void violation(const char* kind, const Asked& asked, const std::string& why = "");
  [[nodiscard]] const Connection& connection_of(const Asked& asked) const {
    return ledger_.connections[asked.connection];
  }

  World& world_;
  Witness& next_;
  const Plan& plan_;
  const Ledger& ledger_;
  Report& report_;
};

}  // namespace mbgate::judge
