// SPDX-License-Identifier: Apache-2.0
#include "soak/rule_rates.hpp"

#include <algorithm>

namespace mbgate::soak {
namespace {

using namespace std::chrono_literals;

constexpr Duration kAtOnce = 1s;  // of a rate, after a pause
constexpr Duration kRounding = 1us;

}  // namespace

Duration RuleRates::every(const Key& key) const {
  return kAtOnce / static_cast<int>(plan_.rules[key.first].rate);
}

// A stop is never over a rate, and what is refused is not counted.
void RuleRates::accepted(const Asked& asked, Instant now) {
  if (asked.refused || asked.is_stop()) {
    return;
  }
  for (const std::size_t rule : asked.rated) {
    passed_[{rule, asked.host}].push_back({asked.id, static_cast<std::uint64_t>(asked.client),
                                           asked.sequence, now,
                                           asked.ahead || asked.earliest != asked.written});
  }
}

// If all were let through that may have been before it. At one instant the gateway takes what comes
// from other clients in an order that nobody outside sees.
bool RuleRates::may_be_over(const Key& key, const Passed& asked) const {
  Instant counted_until = Instant::min();
  for (const Passed& other : passed_.at(key)) {
    const bool is_before =
        other.at < asked.at ||
        (other.at == asked.at && (other.client != asked.client || other.sequence < asked.sequence));
    if (other.id != asked.id && (is_before || other.unsure || asked.unsure)) {
      const Instant at = other.unsure ? std::max(other.at, asked.at) : other.at;
      counted_until = std::max(counted_until, at) + every(key);
    }
  }
  return counted_until > asked.at + kAtOnce - every(key) - kRounding;
}

bool RuleRates::is_refused(const Asked& asked, Instant now) {
  if (asked.is_stop() || asked.surely_on_wire) {
    return false;
  }
  // It was perhaps refused before a reload, and its answer was held back.
  bool is_over = asked.ordered && were_over_.contains(asked.id);
  for (const std::size_t rule : asked.rated) {
    const Key key{rule, asked.host};
    const auto& passed = passed_[key];
    const auto entry = std::ranges::find(passed, asked.id, &Passed::id);
    const bool is_at_once =
        entry != passed.end() && (asked.ordered || entry->unsure || entry->at == now);
    is_over = is_over || (is_at_once && may_be_over(key, *entry));
  }
  if (is_over) {
    for (const std::size_t rule : asked.rated) {
      std::erase_if(passed_[{rule, asked.host}],
                    [&](const Passed& it) { return it.id == asked.id; });
    }
  }
  return is_over;
}

std::string RuleRates::let_through(const Asked& asked) {
  std::string broken;
  if (asked.any_code) {
    return broken;  // the gateway may have refused it
  }
  for (const std::size_t rule : asked.rated) {
    const Key key{rule, asked.host};
    auto& passed = passed_[key];
    const auto entry = std::ranges::find(passed, asked.id, &Passed::id);
    if (entry == passed.end() || entry->unsure) {
      continue;
    }
    entry->surely = true;
    Instant counted_until = Instant::min();
    for (const Passed& it : passed) {
      if (!it.surely) {
        continue;
      }
      if (counted_until > it.at + kAtOnce - every(key) + kRounding) {
        broken = "rule " + std::to_string(rule) + " lets host " + std::to_string(asked.host) +
                 " do too much";
      }
      counted_until = std::max(counted_until, it.at) + every(key);
    }
  }
  return broken;
}

// What was perhaps accepted only now still counts. But it may as well have been refused before, by
// what does not count any more.
void RuleRates::after_reload() {
  for (auto& [key, passed] : passed_) {
    for (const Passed& it : passed) {
      if (!it.surely && may_be_over(key, it)) {
        were_over_.insert(it.id);
      }
    }
    std::erase_if(passed, [](const Passed& it) { return !it.unsure || it.surely; });
  }
}

}  // namespace mbgate::soak
