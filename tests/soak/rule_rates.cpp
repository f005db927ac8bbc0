// SPDX-License-Identifier: Apache-2.0
#include "soak/rule_rates.hpp"

#include <algorithm>

namespace mbgate::soak {
namespace {

using namespace std::chrono_literals;

constexpr Duration kAtOnce = 1s;  // of a rate, after a pause
constexpr Duration kRounding = 1us;

// What was accepted at `at` has its turn behind those before it.
Instant count(Instant counted_until, Instant at, Duration every) {
  return std::max(counted_until, at) + every;
}

}  // namespace

Duration RuleRates::every(const Key& key) const {
  return kAtOnce / static_cast<int>(plan_.rules[key.first].rate);
}

// A stop is never over a rate, and what is refused is not counted.
void RuleRates::accepted(const Asked& asked, Instant now) {
  if (asked.refused || asked.is_stop()) {
    return;
  }
  const bool is_unsure = asked.ahead || asked.earliest != asked.written;
  for (const std::size_t rule : asked.rated) {
    counted_[{rule, asked.host}].passed.push_back(
        {asked.id, static_cast<std::uint64_t>(asked.client), asked.sequence, now,
         is_unsure ? Instant::max() : now});
  }
}

// If all were let through that may have been before it, as late as they may have been. At one
// instant the gateway takes what comes from other clients in an order that nobody outside sees.
bool RuleRates::may_be_over(const Key& key, const Passed& asked) const {
  const Counted& counted = counted_.at(key);
  std::vector<Instant> before;
  for (const Passed& other : counted.passed) {
    const bool is_before =
        other.at < asked.at ||
        (other.at == asked.at && (other.client != asked.client || other.sequence < asked.sequence));
    const bool may_be =
        is_before || ((other.is_unsure() || asked.is_unsure()) && other.at <= asked.latest);
    if (other.id != asked.id && may_be) {
      before.push_back(std::min(std::max(other.at, asked.at), other.latest));
    }
  }
  std::ranges::sort(before);
  Instant counted_until = counted.perhaps_until;
  for (const Instant at : before) {
    counted_until = count(counted_until, at, every(key));
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
    const auto& passed = counted_[key].passed;
    const auto entry = std::ranges::find(passed, asked.id, &Passed::id);
    const bool is_at_once =
        entry != passed.end() && (asked.ordered || entry->is_unsure() || entry->at == now);
    is_over = is_over || (is_at_once && may_be_over(key, *entry));
  }
  if (is_over) {
    for (const std::size_t rule : asked.rated) {
      std::erase_if(counted_[{rule, asked.host}].passed,
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
    Counted& counted = counted_[key];
    const auto entry = std::ranges::find(counted.passed, asked.id, &Passed::id);
    if (entry == counted.passed.end() || entry->is_unsure()) {
      continue;
    }
    entry->surely = true;
    Instant counted_until = counted.surely_until;
    for (const Passed& it : counted.passed) {
      if (!it.surely) {
        continue;
      }
      if (counted_until > it.at + kAtOnce - every(key) + kRounding) {
        broken = "rule " + std::to_string(rule) + " lets host " + std::to_string(asked.host) +
                 " do too much";
      }
      counted_until = count(counted_until, it.at, every(key));
    }
  }
  return broken;
}

void RuleRates::closed(const Asked& asked, Instant now, Duration lateness) {
  were_over_.erase(asked.id);
  for (const std::size_t rule : asked.rated) {
    const Key key{rule, asked.host};
    auto& passed = counted_[key].passed;
    const auto entry = std::ranges::find(passed, asked.id, &Passed::id);
    if (entry != passed.end()) {
      entry->is_open = false;
      entry->latest = std::min(entry->latest, now + lateness);
    }
    forget_old(key, now);
  }
}

// What was surely accepted before all that is open. A rule that has let something through counts
// for no longer than this takes.
void RuleRates::forget_old(const Key& key, Instant now) {
  Counted& counted = counted_[key];
  Instant oldest = now;
  for (const Passed& it : counted.passed) {
    oldest = it.is_open ? std::min(oldest, it.at) : oldest;
  }
  std::vector<Instant> perhaps;
  std::erase_if(counted.passed, [&](const Passed& it) {
    if (it.latest >= oldest) {
      return false;
    }
    perhaps.push_back(it.latest);
    if (it.surely) {
      counted.surely_until = count(counted.surely_until, it.at, every(key));
    }
    return true;
  });
  std::ranges::sort(perhaps);
  for (const Instant at : perhaps) {
    counted.perhaps_until = count(counted.perhaps_until, at, every(key));
  }
  if (!perhaps.empty()) {
    counted.perhaps_until = std::min(counted.perhaps_until, perhaps.back() + kAtOnce);
  }
}

// What was perhaps accepted only now still counts. But it may as well have been refused before, by
// what does not count any more.
void RuleRates::after_reload(Instant now) {
  for (auto& [key, counted] : counted_) {
    for (const Passed& it : counted.passed) {
      if (it.is_open && !it.surely && may_be_over(key, it)) {
        were_over_.insert(it.id);
      }
    }
    std::erase_if(counted.passed, [&](const Passed& it) { return it.surely || it.latest <= now; });
    counted.perhaps_until = counted.surely_until = Instant::min();
  }
}

}  // namespace mbgate::soak
