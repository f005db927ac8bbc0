// SPDX-License-Identifier: Apache-2.0
// Truths of what is configured for clients and not of lines: rights, writers, rates, the order of
// answers, counters. It tells the judge of lines what it sees.
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <set>

#include "world/world.hpp"

namespace mbgate::judge {

using namespace world;  // NOLINT(google-build-using-namespace): it is about nothing else

/// Registers; nothing: whatever they hold.
using Words = std::vector<std::optional<std::uint64_t>>;

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
  void gone(Id connection) override;
  void reloaded() override { next_.reloaded(); }
  /// After come_to_rest(), before anything else is asked.
  void check_counters();
  /// After check_rest(), which asked every drive.
  void check_status();

 private:
  // truth_rights.cpp
  void check_denied(const Asked& asked);
  void check_withdrawn(const Sent& sent);
  // Others than the one who writes do not.
  struct Written {
    Instant given;  ///< accepted then at the earliest
    Instant sent;   ///< and then at the latest
    unsigned process;
  };
  void note_write(const Asked& asked);
  void check_writer(const Sent& sent);
  [[nodiscard]] bool may_be_owned(const Asked& asked) const;

  // truth_rates.cpp: beyond a rate nothing goes; what is under it is not refused for nothing.
  struct Rate {
    unsigned per_second;
    std::multiset<Instant> given{};  ///< of those that surely went through
  };
  using RateKey = std::pair<std::size_t, unsigned>;  ///< rule, or listener, and host
  void note_gone_through(const Asked& asked);
  void count(std::map<RateKey, Rate>& rates, const RateKey& key, unsigned per_second,
             const Asked& asked);
  void check_busy(const Asked& asked);
  void check_refused_writes();
  std::set<Id> refused_behind_;  ///< transmissions: writes were refused since, for no known reason
  [[nodiscard]] Instant ended(const Asked& asked) const;
  [[nodiscard]] bool may_be_over(const Asked& asked) const;
  [[nodiscard]] bool may_be_full(const Asked& asked) const;
  [[nodiscard]] bool may_not_be_written(const Asked& asked) const;

  // truth_kinds.cpp
  void check_forms(const Asked& asked);
  void note_due(Id asked);
  void check_order(Id asked);

  // truth_counters.cpp
  struct Bounds {
    std::uint64_t least = 0;
    std::uint64_t most = 0;
  };
  void compare(const std::string& what, std::uint64_t shown, Bounds seen);
  void check_bus(std::size_t at, const gateway::BusStatus& bus);
  void check_listener(std::size_t at, const gateway::ListenerStatus& listener);

  // truth_status.cpp
  std::optional<Octets> ask_gateway(const Octets& pdu);
  /// The answer begins so, and has this size.
  void expect(const Octets& pdu, const Octets& begin, std::optional<std::size_t> size = {});
  void check_blocks(unsigned first, const std::function<Words()>& expected);
  void check_identity();
  void check_diagnostics(const gateway::StatusReport& status);
  void check_states(const gateway::StatusReport& status);
  void check_sums(const gateway::StatusReport& status);
  void check_cleared();

  void violation(const char* kind, const Asked& asked, const std::string& why = "");
  [[nodiscard]] const Connection& connection_of(const Asked& asked) const {
    return ledger_.connections[asked.connection];
  }

  World& world_;
  Witness& next_;
  const Plan& plan_;
  const Ledger& ledger_;
  Report& report_;
  std::map<std::size_t, std::map<unsigned, Written>> written_;  ///< by station and host
  std::map<std::size_t, std::map<unsigned, Instant>> wanted_;   ///< likewise: asked to write
  std::map<std::size_t, Instant> broadcast_;                    ///< by bus: the last one
  std::map<RateKey, Rate> of_rules_;
  std::map<RateKey, Rate> of_listeners_;
  std::map<unsigned, std::deque<Id>> recent_;  ///< by host: given within a second or so
  std::set<Id> open_;                          ///< given, not answered, and somebody waits
  std::map<Id, std::deque<Id>> due_;           ///< by connection, where answers are ordered
};

}  // namespace mbgate::judge
