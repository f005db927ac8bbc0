// SPDX-License-Identifier: Apache-2.0
// The access rules of one seed, and what they deny, worked out from the words of the documentation:
// the first rule that fits decides, what none fits is denied, and a request that reads and writes
// asks twice.
#pragma once

#include <cstdint>
#include <vector>

namespace mbgate::soak {

struct Asked;
struct SoakPlan;

/// What is empty fits everything.
struct SpokenRule {
  bool permits = true;
  bool reads = true;   ///< it is about requests that read,
  bool writes = true;  ///< or about those that write
  std::vector<unsigned> hosts{};
  std::vector<std::uint8_t> units{};
  std::vector<std::uint8_t> functions{};
};

/// Some plants have rules, but none whose devices are written to when those who may write are gone:
/// who that is would be a question of its own.
void draw_access(SoakPlan& plan, std::uint64_t seed);
/// 01 if the rules deny it, whatever else would be said of it.
void deny_by_rules(const SoakPlan& plan, Asked& asked);

}  // namespace mbgate::soak
