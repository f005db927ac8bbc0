// SPDX-License-Identifier: Apache-2.0
// What is fast enough is a figure of a whole run: answers that came in time reach their clients,
// and a good frame that does not fit ends a wait.
#include "judge/judge.hpp"

namespace mbgate::judge {

// A frame of the drive that was asked, which is not what was asked for. One of another function may
// be another client's, and ends no wait.
void Judge::came(std::size_t bus) {
  const Came& came = ledger_.lines[bus].came.back();
  if (came.is_second) {
    misfits_.erase(came.answers);  // close behind each other the two may look like one frame
  } else if (came.answers != kNone && came.ends_wait) {
    misfits_[came.answers] = came.at;
  }
}

// Nobody can know whose answer it is that comes later than `quarantine_max` (or later than its
// tail, where it is a misfit that happens to fit the next request, or an adapter kept the request),
// than the answer to a later request, or than the next process listens first. It takes the place of
// another one, and this that of the next; of the parts of a request any may be wrong. A stop waits
// for none of them.
bool Judge::is_later_than_ever(const Asked& asked, const Came& last) const {
  const std::size_t at = *asked.intent.station;
  const Station& station = plan_.stations[at];
  const drive::DeviceTiming& timing = plan_.timing_of(station);
  const Instant asked_at = asked.sent.empty() ? oldest_of(asked, plan_.device_of(station))
                                              : ledger_.sent[asked.sent.front()].begin;
  const Instant begun = std::min(asked_at, ledger_.sent[last.answers].begin);
  const LineBook& line = ledger_.lines[station.bus];
  const Duration tail = timing.response_timeout + quarantine_of(timing);
  const bool is_stop = asked.intent.kind == Kind::stop;
  const Duration longest_tail = tail + timing.response_wait + 20ms;
  const Instant heard =
      line.opened + (is_stop ? 0ms : plan_.bus(station.bus).listen_first.value_or(tail));
  Id newest = 0;
  return std::ranges::any_of(line.came, [&](const Came& it) {
    if (it.answers == kNone || ledger_.sent[it.answers].station != at) {
      return false;
    }
    newest = std::max(newest, it.answers);
    const Sent& sent = ledger_.sent[it.answers];
    const bool was_kept = sent.left != kNever && sent.left > sent.end + 20ms;
    const Duration most = is_stop || !it.fits || was_kept ? longest_tail : timing.quarantine_max;
    return it.at >= begun && (it.answers < newest || (!it.was_held && it.at > sent.begin + most) ||
                              (sent.process != ledger_.process && it.at > heard) ||
                              (it.at > sent.end + longest_tail && is_after_hold(it)));
  });
}

// An answer before it has shown how fast the device is, and twice that time was waited for each
// transmission that was left (docs/behaviour.md, "the hold").
bool Judge::is_after_hold(const Came& late) const {
  constexpr int kFactor = 2;
  const Sent& sent = ledger_.sent[late.answers];
  return std::ranges::any_of(ledger_.lines[sent.bus].came, [&](const Came& it) {
    const auto is_left = [&](const Sent& other) {
      return other.station == sent.station && other.begin < it.at;
    };
    if (it.answers >= late.answers || !is_left(sent) || !is_left(ledger_.sent[it.answers])) {
      return false;  // kNone is the largest
    }
    const auto after = ledger_.sent.begin() + it.answers + 1;
    return late.at > it.at + kFactor * std::count_if(after, ledger_.sent.end(), is_left) *
                                 (it.at - ledger_.sent[it.answers].begin);
  });
}

void Judge::note_share(const Asked& asked) {
  constexpr std::uint8_t kUnanswered = 0x0B;
  constexpr Duration kLateness = 60ms;  // of adapters and drivers
  if (asked.intent.kind == Kind::own || asked.sent.empty() || !asked.intent.station) {
    return;
  }
  const Sent& sent = ledger_.sent[asked.sent.back()];
  const LineBook& line = ledger_.lines[sent.bus];
  const drive::DeviceTiming& timing = plan_.timing_of(plan_.stations[*asked.intent.station]);
  const Instant due = sent.end + timing.response_timeout + timing.response_wait;
  const bool is_plain = line.openings == sent.opening && ledger_.reloaded < sent.begin &&
                        ledger_.stopping == kNever && !plan_.driver.stalls && !plan_.driver.stops;
  if (!is_plain || &ledger_.asked[sent.asked.front()] != &asked) {
    return;  // one of those that share a transmission
  }
  Share& share = shares_[sent.bus];
  const bool is_lost = asked.answer[0] >= 0x80 && asked.answer[1] == kUnanswered;
  if (sent.answered < due - kLateness && asked.intent.kind == Kind::read && sent.exceptions == 0) {
    ++(is_lost ? share.lost : share.got);
  }
  const auto misfit = misfits_.find(asked.sent.back());
  const bool is_ordered = plan_.settings.listeners[door_of(asked).listener].ordered;
  const Duration allowed = slack_of(plan_.bus(sent.bus)) + kLateness;
  const bool ends = !plan_.is_tcp(sent.bus) || plan_.bus(sent.bus).check_transaction;
  if (misfit != misfits_.end() && asked.intent.kind == Kind::write && is_lost && ends &&
      !is_ordered && due - misfit->second > 2 * allowed) {
    ++(asked.answered > misfit->second + allowed ? share.waited : share.ended);
  }
}

void Judge::check_shares() {
  constexpr unsigned kFew = 5;
  for (const auto& [bus, share] : shares_) {
    const std::string text = plan_.bus(bus).name + ": ";
    if (share.lost > kFew + share.got * 3 / 2) {
      violation("answers_lost", text + std::to_string(share.lost) + " of " +
                                    std::to_string(share.lost + share.got) + " that came in time");
    }
    if (share.waited > 2 + share.ended) {
      violation("misfits_waited", text + std::to_string(share.waited) + " of " +
                                      std::to_string(share.waited + share.ended));
    }
  }
}

}  // namespace mbgate::judge
