// SPDX-License-Identifier: Apache-2.0
#include "gateway/access/access_book.hpp"

#include <utility>

#include "gateway/limits.hpp"

namespace mbgate::gateway {
namespace {

bool has_rate(const routing::AccessRule* rule) { return rule != nullptr && rule->per_second != 0; }

}  // namespace

bool AccessBook::take(const RuleVerdict& verdict, const routing::ClientAddress& client,
                      Instant now) {
  if (!has_room(verdict.rule, client, now) || !has_room(verdict.other, client, now)) {
    return false;
  }
  count(verdict.rule, client, now);
  count(verdict.other, client, now);
  return true;
}

bool AccessBook::has_room(const routing::AccessRule* rule, const routing::ClientAddress& client,
                          Instant now) {
  if (!has_rate(rule)) {
    return true;
  }
  const auto known = rates_.find({rule, client});
  if (known != rates_.end()) {
    return known->second.next(rule->per_second, now) <= now;
  }
  if (rates_.size() >= kRatedClients) {
    std::erase_if(rates_, [now](const auto& entry) { return entry.second.is_rested(now); });
  }
  return rates_.size() < kRatedClients;
}

void AccessBook::count(const routing::AccessRule* rule, const routing::ClientAddress& client,
                       Instant now) {
  if (has_rate(rule)) {
    rates_[{rule, client}].take(rule->per_second, now);
  }
}

std::optional<std::uint64_t> AccessBook::note_denied(const routing::ClientAddress& client,
                                                     Instant now) {
  const auto is_over = [now](const Told& told) { return now - told.at >= kDenialTold; };
  const auto known = told_.find(client);
  if (known != told_.end() && !is_over(known->second)) {
    ++known->second.left_out;
    return std::nullopt;
  }
  if (known != told_.end()) {
    return std::exchange(known->second, Told{now}).left_out;
  }
  if (told_.size() >= kDeniedClients) {
    std::erase_if(told_, [&](const auto& entry) { return is_over(entry.second); });
  }
  if (told_.size() >= kDeniedClients) {
    return std::nullopt;
  }
  told_.emplace(client, Told{now});
  return 0;
}

}  // namespace mbgate::gateway
