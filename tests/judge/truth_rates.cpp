// SPDX-License-Identifier: Apache-2.0
// So many requests as a rate says may go through at once, and then one after the other; stops never
// count. Who is under all rates, and meets no other reason, does not get 06 at once.
#include <algorithm>

#include "judge/rules_judge.hpp"

namespace mbgate::judge {
namespace {
constexpr std::uint8_t kTryAgainLater = 0x06;
constexpr Duration kKept = 10s;
constexpr Duration kUsual = 30ms;  // that a driver may be late, where it is not stopped
}  // namespace

// Taken between when it was given and its answer.
void RulesJudge::count(std::map<RateKey, Rate>& rates, const RateKey& key, unsigned per_second,
                       const Asked& asked) {
  Rate& rate = rates[key];
  if (rate.per_second != per_second) {
    rate = {per_second};
  }
  rate.given.insert(asked.given);
  const Instant anew = std::max({ledger_.reloaded, ledger_.started, world_.now() - kKept});
  rate.given.erase(rate.given.begin(), rate.given.upper_bound(anew));
  std::int64_t number = 0;
  for (auto it = rate.given.rbegin(); it != rate.given.rend(); ++it) {
    const std::int64_t most = per_second + (world_.now() - *it) * per_second / 1s + 1;
    if (++number > most) {
      violation("over_its_rate", asked,
                std::to_string(number) + " of " + std::to_string(per_second) + " a second in " +
                    std::to_string((world_.now() - *it) / 1ms) + " ms");
      rate.given.clear();
      return;
    }
  }
}

void RulesJudge::note_gone_through(const Asked& asked) {
  const Connection& connection = connection_of(asked);
  const bool is_sure = asked.answer.size() > 1 && asked.answer[0] < 0x80;
  const bool stops_all =
      asked.intent.kind == Kind::broadcast && std::ranges::all_of(asked.intent.writes, is_stopping);
  if (!is_sure || asked.intent.kind == Kind::own || asked.intent.kind == Kind::stop || stops_all ||
      asked.written <= ledger_.reloaded || asked.given <= ledger_.started) {
    return;  // or what it knows of the rules may be outdated
  }
  for (const std::size_t rule : asked.intent.rated) {
    count(of_rules_, {rule, connection.host}, plan_.rules[rule].rate, asked);
  }
  const unsigned most = plan_.settings.listeners[connection.listener].max_requests_per_second;
  if (most > 0) {
    count(of_listeners_, {connection.listener, connection.host}, most, asked);
  }
}

// It may have been taken as late as this.
Instant RulesJudge::ended(const Asked& asked) const {
  return asked.answers > 0         ? asked.answered
         : asked.given_up          ? asked.given + kKept
         : asked.dropped           ? connection_of(asked).gone
         : asked.intent.answer_due ? world_.now()
                                   : asked.given + kKept;
}

// Fewer than the rate within the last second leave room for one more.
bool RulesJudge::may_be_over(const Asked& asked) const {
  const Connection& connection = connection_of(asked);
  const auto& recent = recent_.at(connection.host);
  const unsigned most = plan_.settings.listeners[connection.listener].max_requests_per_second;
  const auto& rated = asked.intent.rated;
  unsigned on_listener = 0;
  std::vector<unsigned> by_rules(rated.size());
  for (auto id = recent.rbegin(); id != recent.rend(); ++id) {
    const Asked& other = ledger_.asked[*id];
    if (ended(other) + 1s < asked.given) {
      continue;
    }
    on_listener += connection_of(other).listener == connection.listener ? 1U : 0U;
    if (most > 0 && on_listener + 1 >= most) {
      return true;
    }
    for (std::size_t at = 0; at < rated.size(); ++at) {
      const bool counts = other.intent.kind == Kind::broadcast || other.intent.refused ||
                          std::ranges::count(other.intent.rated, rated[at]) > 0;
      by_rules[at] += counts ? 1U : 0U;
      if (by_rules[at] + 1 >= plan_.rules[rated[at]].rate) {
        return true;
      }
    }
  }
  return false;
}

// A request may be divided into so many.
bool RulesJudge::may_be_full(const Asked& asked) const {
  constexpr std::size_t kMostParts = 40;
  const std::size_t bus = plan_.stations[*asked.intent.station].bus;
  return open_.size() * kMostParts >= plan_.bus(bus).queue;
}

// Its device is offline, another one writes, a stop has just come, or it is old.
bool RulesJudge::may_not_be_written(const Asked& asked) const {
  const std::size_t at = *asked.intent.station;
  const Station& station = plan_.stations[at];
  const auto& last = ledger_.last_sent[at];
  const auto& stops = ledger_.stops[at];
  const auto by_all = broadcast_.find(station.bus);
  if (!station.device || plan_.is_tcp(station.bus) || last.empty() || may_be_owned(asked) ||
      plan_.has_failsafe(station) || connection_of(asked).half_closed != kNever) {
    return true;
  }
  const Sent& sent = ledger_.sent[last.back()];
  const drive::DeviceTiming& timing = plan_.timing_of(station);
  const bool was_well = sent.process == ledger_.process && sent.expects_answer &&
                        sent.answered != kNever && sent.answered + kUsual < asked.given &&
                        sent.answered < sent.end + probe_timeout_of(timing) - kUsual;
  const bool was_stopped = !stops.empty() && ledger_.asked[stops.back()].given + 1s > asked.given;
  const bool was_called = by_all != broadcast_.end() && by_all->second + 1s > asked.given;
  // A write is as old as its client's socket was last seen empty.
  const bool was_behind = std::ranges::any_of(recent_.at(connection_of(asked).host), [&](Id id) {
    const Asked& other = ledger_.asked[id];
    return &other != &asked && other.connection == asked.connection &&
           other.written <= asked.written && other.given >= asked.written;
  });
  const bool is_old = was_behind || asked.written + kUsual < asked.given;
  return !was_well || was_stopped || was_called || is_old;
}

void RulesJudge::check_busy(const Asked& asked) {
  auto& recent = recent_[connection_of(asked).host];
  while (!recent.empty() && ended(ledger_.asked[recent.front()]) + 2s < world_.now()) {
    recent.pop_front();
  }
  const std::uint8_t code = asked.answer.size() == 2 ? asked.answer[1] : 0;
  const Intent& intent = asked.intent;
  // It is as old as its first byte, and a reload may have changed what it means.
  if (code != kTryAgainLater || intent.refused || !intent.station || asked.withdrawn ||
      ledger_.stopping != kNever || asked.written <= ledger_.reloaded + kUsual) {
    return;
  }
  if (intent.kind == Kind::stop) {  // there is memory for so many that differ
    constexpr std::ptrdiff_t kMany = 200;
    const auto is_due = [this](Id id) { return ledger_.asked[id].answers == 0; };
    if (asked.sent.empty() &&
        std::ranges::count_if(ledger_.stops[*intent.station], is_due) < kMany) {
      violation("stop_refused", asked);
    }
    return;
  }
  // Where the process stood still, today's gateway takes reads for as old as that, too.
  const bool stands_still = plan_.driver.stalls || plan_.driver.stops;
  const bool is_at_once = asked.answered == asked.given && asked.sent.empty() &&
                          (intent.codes >> kTryAgainLater & 1U) == 0;
  const bool is_read = intent.kind == Kind::read;
  if (!is_at_once || stands_still || may_be_full(asked) ||
      (!is_read && may_not_be_written(asked)) || may_be_over(asked)) {
    return;
  }
  if (is_read) {
    violation("busy_for_nothing", asked);
  } else {
    refused_behind_.insert(ledger_.last_sent[*intent.station].back());
  }
}

// How old a write is, only the gateway knows, and whether what came shows that a drive is there: a
// few get 06 for that. Behind one transmission they are one case.
void RulesJudge::check_refused_writes() {
  const auto writes = std::ranges::count_if(ledger_.asked, [](const Asked& it) {
    return it.intent.kind == Kind::write && it.answers > 0 && it.answer[0] < 0x80;
  });
  const std::ptrdiff_t refused = std::ssize(refused_behind_);
  if (refused > 20 + writes / 10) {
    report_.violation("busy_for_nothing", std::to_string(refused) + " writes beside " +
                                              std::to_string(writes) + " that were done");
  }
}

}  // namespace mbgate::judge
