// SPDX-License-Identifier: Apache-2.0
// What is fast enough is a figure of a whole run: answers that came in time reach their clients,
// and a good frame that does not fit ends a wait.
#include "judge/judge.hpp"

namespace mbgate::judge {

using namespace std::chrono_literals;

namespace {
constexpr std::uint8_t kUnanswered = 0x0B;
constexpr Duration kLateness = 60ms;  // of adapters and drivers
}  // namespace

// A frame of the drive that was asked, which is not what was asked for. One of another function may
// be another client's, and ends no wait.
void Judge::came(std::size_t bus) {
  const Came& came = ledger_.lines[bus].came.back();
  if (came.answers != kNone && came.ends_wait && !came.is_second) {
    misfits_[came.answers] = came.at;
  }
  if (came.answers != kNone && ledger_.sent[came.answers].station) {
    note_slip(came);
  }
}

// Of an answer to an ordinary register, with the 20 ms for which an adapter may keep it; or later
// than the next process listens first, if the one that has asked was killed.
bool Judge::is_beyond_its_tail(const Came& came) const {
  const Sent& sent = ledger_.sent[came.answers];
  const drive::DeviceTiming& timing = plan_.timing_of(plan_.stations[*sent.station]);
  const auto& listens = plan_.bus(sent.bus).listen_first;
  const bool was_killed = sent.process != ledger_.process && listens;
  return came.at > sent.end + timing.response_timeout + timing.response_wait +
                       quarantine_of(timing) + 20ms ||
         (was_killed && came.at > ledger_.lines[sent.bus].opened + *listens);
}

// It ends with an answer to what was sent last, if that comes alone.
void Judge::note_slip(const Came& came) {
  const std::size_t at = *ledger_.sent[came.answers].station;
  const auto& last = ledger_.last_sent[at];
  if (is_beyond_its_tail(came)) {
    slipped_.insert(at);
  } else if (!last.empty() && last.back() == came.answers && came_at_[at] < came.at) {
    slipped_.erase(at);
  }
  came_at_[at] = came.at;
}

void Judge::note_share(const Asked& asked) {
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
  if (misfit != misfits_.end() && asked.intent.kind == Kind::write && is_lost &&
      !plan_.is_tcp(sent.bus) && !is_ordered && due - misfit->second > 2 * allowed) {
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
