// SPDX-License-Identifier: Apache-2.0
#include "gateway/access/access_book.hpp"

#include <utility>

#include "gateway/limits.hpp"

namespace mbgate::gateway {
namespace {

bool has_rate(const routing::AccessRule* rule) { return rule != nullptr && rule->per_second != 0; }

}  // namespace

bool AccessBook::take(const RuleVerdict& verdict, const ClientKey& client, Instant now) {
  if (!has_room(verdict.rule, client, now) || !has_room(verdict.other, client, now)) {
    return false;
  }
  count(verdict.rule, client, now);
  count(verdict.other, client, now);
  return true;
}

bool AccessBook::has_room(const routing::AccessRule* rule, const ClientKey& client, Instant now) {
  if (!has_rate(rule)) {
    return true;
  }
  const auto known = rates_.find({rule, client});
  if (known != rates_.end()) {
    return known->second.has_room(rule->per_second, now);
  }
  if (rates_.size() >= kRatedClients) {
    std::erase_if(rates_, [now](const auto& entry) { return entry.second.is_rested(now); });
  }
  return rates_.size() < kRatedClients;
}

void AccessBook::count(const routing::AccessRule* rule, const ClientKey& client, Instant now) {
  if (has_rate(rule)) {
    rates_[{rule, client}].take(rule->per_second, now);
  }
}

}  // namespace mbgate::gateway
