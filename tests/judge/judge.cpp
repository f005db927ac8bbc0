// SPDX-License-Identifier: Apache-2.0
#include "judge/judge.hpp"

#include <algorithm>
#include <ranges>

namespace mbgate::judge {

std::string Judge::name(const Asked& asked) const {
  const auto station = asked.intent.station;
  return "at " + std::to_string(now().time_since_epoch() / 1us) + " us: client " +
         std::to_string(asked.connection) + " transaction " + std::to_string(asked.transaction) +
         " unit " + std::to_string(asked.intent.unit) + " pdu " + hex(asked.intent.pdu) +
         " given " + std::to_string(asked.given.time_since_epoch() / 1us) +
         (asked.answers > 0 ? " answer " + hex(asked.answer) : "") +
         (station ? " (" + plan_.bus(plan_.stations[*station].bus).name + " address " +
                        std::to_string(plan_.stations[*station].address) + ")"
                  : "");
}

std::string Judge::name(const Sent& sent) const {
  return "at " + std::to_string(sent.begin.time_since_epoch() / 1us) +
         " us: " + plan_.bus(sent.bus).name + " address " + std::to_string(sent.address) + " pdu " +
         hex(sent.pdu);
}

void Judge::asked(Id id) {
  const Asked& asked = ledger_.asked[id];
  if (asked.intent.kind != Kind::own) {
    deadlines_[id] = deadline_of(asked);
  }
}

// A reload may give what waits more time, and the next one less.
void Judge::reloaded() {
  for (auto& [id, deadline] : deadlines_) {
    deadline = std::max(deadline, deadline_of(ledger_.asked[id]));
  }
}

void Judge::given(Id id) {
  const Asked& asked = ledger_.asked[id];
  has_broadcast_ = has_broadcast_ || asked.intent.kind == Kind::broadcast;
  note_asked_of(asked);
}

void Judge::answered(Id id) {
  const Asked& asked = ledger_.asked[id];
  deadlines_.erase(id);
  if (asked.answers > 1) {
    violation("answered_twice", name(asked));
  }
  note_asked_of(asked);
  note_share(asked);
  if (asked.intent.kind == Kind::own) {
    return;
  }
  check_overdue(asked);
  if (asked.answer.empty() || (asked.answer[0] & 0x7FU) != (asked.intent.pdu[0] & 0x7FU)) {
    violation("other_function", name(asked));
  } else if (asked.answer[0] >= 0x80) {
    check_exception(asked);
    check_refused_stop(asked);
  } else if (asked.intent.refused && !asked.perhaps_outdated) {
    violation("not_refused", name(asked));
  } else if (asked.intent.kind == Kind::read) {
    note_echo_shown(asked);
    check_read(id);
  } else {
    check_write(id);
  }
}

void Judge::sent(Id id) {
  const Sent& sent = ledger_.sent[id];
  if (!sent.readable) {
    violation("unreadable", name(sent));
    return;
  }
  const bool is_reported = plan_.lines[sent.bus].tells_unsent && !plan_.is_tcp(sent.bus);
  if (is_reported && sent.station && sent.expects_answer) {
    waits_[id] = longest_wait_of(*sent.station);
  }
  check_silence(id);
  check_waiting(id);
  check_gap(id);
  check_hold(id);
  check_half(id);
  if (sent.is_failsafe) {
    check_failsafe(sent);
    return;
  }
  check_stop_time(id);
  check_asked_for(sent);
  check_limits(sent);
  if (!sent.cells.empty()) {
    check_once(id);
    check_stopped(sent);
  }
  check_late(id);
  check_gone(id);
}

// The gateway understands 64 requests of a connection at a time, and the next when one is answered.
bool Judge::is_overfull(Id connection, Instant at) const {
  constexpr std::ptrdiff_t kUnderstood = 64;
  return std::ranges::count_if(ledger_.asked, [&](const Asked& it) {
           return it.connection == connection && it.given <= at && it.answered > at;
         }) >= kUnderstood;
}

// When the clients leave a minute after the last fault. What a full connection held back is
// younger. Stops of a storm may still wait, and, with `ordered`, what waits for their answers.
void Judge::check_answered() {
  const auto waits = [&](const Asked& it) {
    const Connection& connection = ledger_.connections[it.connection];
    return connection.gone == ledger_.rested && connection.half_closed == kNever &&
           it.given < ledger_.rested - 30s && it.answers == 0 && !it.given_up &&
           it.intent.answer_due;
  };
  for (const Asked& asked : ledger_.asked | std::views::filter(waits)) {
    const Id at = asked.connection;
    const auto& listener = plan_.settings.listeners[ledger_.connections[at].listener];
    const auto stops = std::ranges::count_if(ledger_.asked, [&](const Asked& it) {
      return it.connection == at && it.intent.kind == Kind::stop && waits(it);
    });
    const bool is_replaced =
        listener.one_at_a_time && (asked.intent.kind == Kind::broadcast ||
                                   std::ranges::any_of(ledger_.asked, [&](const Asked& it) {
                                     return it.connection == at && &it > &asked;
                                   }));
    if (asked.intent.kind != Kind::stop && !is_replaced && (stops == 0 || !listener.ordered) &&
        !is_overfull(at, ledger_.rested)) {
      violation("unanswered", name(asked));
    }
  }
}

void Judge::check_rest() {
  check_failsafe_done();
  check_shares();
  std::ranges::for_each(waits_, [this](const auto& wait) { check_heard(wait.first); });
  check_answered();
  constexpr unsigned kTries = 240;  // a slow drive may have dozens of stops to carry out first
  for (std::size_t at = 0; at < plan_.doors.size(); ++at) {
    const Door& door = plan_.doors[at];
    if (!door.station || door.routed) {
      continue;
    }
    bool is_back = false;
    for (unsigned tries = 0; tries < kTries && !is_back; ++tries) {
      const auto answer = world_.ask(at, 500ms);
      is_back = answer && (*answer)[0] < 0x80;
    }
    if (!is_back) {
      const Station& station = plan_.stations[*door.station];
      violation("not_back",
                plan_.bus(station.bus).name + " address " + std::to_string(station.address));
    }
  }
}

void Judge::check_end() {
  if (!world_.is_finished()) {
    violation("not_finished", "after 2.2 s");
  }
}

}  // namespace mbgate::judge
