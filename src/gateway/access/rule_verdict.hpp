// SPDX-License-Identifier: Apache-2.0
// The verdict of the access rules on a client and on its requests. Used by `--check --who` too.
//
// To change
// - the match of a rule: routing/access_rules; its registers: routing/register_set; the registers
//   and devices of a request, and which clients may connect, and rates: rule_verdict.
// - when a request is checked: gateway/clients/intake; lines about denied requests: report_limit.
// - rules in the configuration: config/sections/rule_section, rule_registers; warnings:
//   config/checks/rule_checks.
// - --check --who: who, app/who/who_options; the places of the other keys: config/diagnostic.
#pragma once

#include <cstdint>
#include <map>
#include <utility>

#include "gateway/second_rate.hpp"
#include "gateway/settings/settings_snapshot.hpp"
#include "routing/access_rules.hpp"
#include "routing/plan.hpp"

namespace mbgate::gateway {

struct RuleVerdict : routing::AccessDecision {
  /// Of a request that reads and writes: the other rule that permits it, if it is another one.
  const routing::AccessRule* other = nullptr;
};

/// May the client have a connection to its listener? If no rule can permit anything to its address,
/// it may not. Its role does not matter: whose role is named nowhere is told so by exception 01.
[[nodiscard]] bool may_connect(const Settings& settings, const ClientInfo& client);

/// The request as it is planned, and so with the registers of the devices that it reaches: behind
/// windows, split, in the order of words of the drive. Of a request that reads and writes (23)
/// each half must be permitted. Without a plan it is one to the status unit, or cannot be planned:
/// then it is denied if it would be so whatever registers it named.
[[nodiscard]] RuleVerdict verdict_on(const SettingsSnapshot& settings, const ClientInfo& client,
                                     std::uint8_t unit, const modbus::Pdu& request,
                                     const routing::Plan* plan);

/// Why it is denied, for people: `rule "panel" (mbgate.toml:12)`, "no rule permits it", ...
[[nodiscard]] std::string denied_by_text(const RuleVerdict& verdict, const ClientInfo& client);

// Remembers for rules with a rate how many requests of each client they have permitted lately.
// Without rules it holds nothing.

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

  std::map<Key, SecondRate> rates_;
};

}  // namespace mbgate::gateway
