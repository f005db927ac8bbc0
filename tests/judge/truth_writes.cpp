// SPDX-License-Identifier: Apache-2.0
// Everything on the wire was asked for; a write goes once, never late, never for a client that has
// gone, never after its stop (promise 3 in docs/behaviour.md), and within the limits of its
// drive (section 7).
#include <algorithm>

#include "judge/judge.hpp"

namespace mbgate::judge {

// The gateway asks for the word order itself, whether or not a client waits for the same.
bool Judge::asks_order(const Sent& sent) const {
  return sent.station && sent.reads && sent.reads->count == 1 &&
         sent.reads->first == kOrderRegister && plan_.stations[*sent.station].device;
}

void Judge::check_asked_for(const Sent& sent) {
  if (sent.asked.empty() && !asks_order(sent)) {
    violation("unasked", name(sent));
    return;
  }
  for (const Id id : sent.asked) {
    const Asked& asked = ledger_.asked[id];
    if (asked.intent.refused) {
      violation("refused_was_sent", name(sent) + " for " + name(asked));
    }
    if (asked.outdated && asked.answers == 0 && ledger_.reloaded < sent.begin && !sent.is_stop &&
        asked.sent.size() == 1 && asked.intent.kind == Kind::write) {
      violation("outdated_was_sent", name(sent) + " for " + name(asked));
    }
    if (asked.answers > 0 && asked.intent.kind != Kind::read && !sent.is_stop) {
      violation("sent_after_answer", name(sent) + " for " + name(asked));
    }
  }
}

void Judge::check_limits(const Sent& sent) {
  const bool is_routed = !sent.asked.empty() && std::ranges::none_of(sent.asked, [&](Id id) {
    return ledger_.asked[id].intent.whole;
  });
  if (!sent.station || sent.is_broadcast) {
    return;
  }
  const drive::Device* device = plan_.device_of(plan_.stations[*sent.station]);
  if (!is_routed || device == nullptr) {
    const bool is_whole = sent.asked.empty() || std::ranges::any_of(sent.asked, [&](Id id) {
                            const Intent& intent = ledger_.asked[id].intent;
                            return !intent.whole || intent.sent == sent.pdu;
                          });
    if (!is_whole && !asks_order(sent)) {
      violation("altered", name(sent));
    }
    return;
  }
  const drive::Limits& limits = device->profile.limits;
  if (sent.reads && sent.reads->count > limits.read_from(sent.reads->table)) {
    violation("limits", name(sent));
  }
  const auto registers = std::ranges::count_if(
      sent.cells, [](const Cell& cell) { return cell.table == Table::holding_registers; });
  if (registers > limits.write_registers) {
    violation("limits", name(sent));
  }
  const bool is_16 = sent.pdu[0] == 0x10 && sent.cells.size() > 1;  // alone it was a 06
  if (is_16 && (cuts_value(sent.cells.front().place) || cuts_value(sent.cells.back().place + 1))) {
    violation("cut_value", name(sent));
  }
}

void Judge::check_once(Id id) {
  const Sent& sent = ledger_.sent[id];
  if (sent.is_stop ||
      (sent.station && plan_.timing_of(plan_.stations[*sent.station]).retry_writes)) {
    return;
  }
  const std::size_t place = sent.is_broadcast ? all_of(sent.bus) : sent.station.value_or(0);
  const auto found = ledger_.carriers.find(key_of(place, sent.cells.front()));
  if (found == ledger_.carriers.end()) {
    return;
  }
  const auto same = std::ranges::count_if(found->second, [&](Id other) {
    return !sent.asked.empty() && ledger_.sent[other].has_other_form == sent.has_other_form &&
           std::ranges::count(ledger_.sent[other].asked, sent.asked.front()) > 0;
  });
  if (same > 1 && !plan_.timing_of(plan_.stations[sent.station.value_or(0)]).retry_writes) {
    violation("sent_twice", name(sent));
  }
}

// What has begun is finished; a stop has no deadline. A request is as old as the process could
// know: it reads what has come, late by no more than its machine makes it.
void Judge::check_late(Id id) {
  const Sent& sent = ledger_.sent[id];
  if (sent.is_stop || sent.asked.empty() || asks_order(sent)) {
    return;
  }
  const bool is_slow_machine = plan_.driver.stalls || plan_.driver.stops;
  const Duration lateness = is_slow_machine ? 600ms : 30ms;
  const auto late_by = [&](Id it) {
    const Asked& asked = ledger_.asked[it];
    const bool is_read = asked.intent.kind == Kind::read;
    const auto stated = deadlines_.find(it);
    const Duration limit =
        std::max(deadline_of(asked), stated == deadlines_.end() ? Duration{0} : stated->second);
    const Instant known = is_read ? asked.given : std::min(asked.given, asked.written + lateness);
    return asked.sent.size() > 1 ? Duration{0} : sent.begin - known - limit;
  };
  Duration least = Duration::max();
  for (const Id it : sent.asked) {
    least = std::min(least, late_by(it));
  }
  if (least > 0ms) {
    violation("late", name(sent) + " for " + name(ledger_.asked[sent.asked.front()]) + ", by " +
                          std::to_string(least / 1us) + " us");
  }
}

// What was not begun by its deadline is refused then. The question for the drive's word order is a
// beginning.
void Judge::check_overdue(const Asked& asked) {
  constexpr Duration kLateness = 60ms;
  const auto& listener = plan_.settings.listeners[door_of(asked).listener];
  const bool has_deadline = asked.intent.kind == Kind::read || asked.intent.kind == Kind::write;
  const bool is_slow_machine = plan_.driver.stalls || plan_.driver.stops;
  if (!has_deadline || !asked.sent.empty() || listener.ordered || is_slow_machine ||
      ledger_.reloaded >= asked.given ||
      asked.answered <= asked.given + deadline_of(asked) + kLateness) {
    return;
  }
  const auto is_question = [&](Id id) {
    return ledger_.sent[id].begin >= asked.given && asks_order(ledger_.sent[id]);
  };
  const bool is_begun = asked.intent.station &&
                        std::ranges::any_of(ledger_.last_sent[*asked.intent.station], is_question);
  if (!is_begun && !is_overfull(asked.connection, asked.given)) {
    violation("overdue", name(asked) + ", after " +
                             std::to_string((asked.answered - asked.given) / 1us) + " us, not " +
                             std::to_string(deadline_of(asked) / 1us));
  }
}

void Judge::check_gone(Id id) {
  const Sent& sent = ledger_.sent[id];
  if (sent.is_stop || sent.is_broadcast || sent.asked.empty()) {
    return;
  }
  const bool is_for_somebody = std::ranges::any_of(sent.asked, [&](Id it) {
    const Asked& asked = ledger_.asked[it];
    const Connection& connection = ledger_.connections[asked.connection];
    const bool is_half_closed = asked.intent.kind != Kind::read &&
                                connection.half_closed < sent.begin && asked.sent.size() == 1;
    return !asked.dropped && !is_half_closed;
  });
  if (!is_for_somebody) {
    violation("for_nobody", name(sent) + " for " + name(ledger_.asked[sent.asked.front()]));
  }
}

// What was accepted before a stop of its drive is not sent after it.
void Judge::check_stopped(const Sent& sent) {
  if (sent.is_stop || !sent.station || sent.asked.empty()) {
    return;
  }
  const Asked& asked = ledger_.asked[sent.asked.front()];
  for (const Id id : ledger_.stops[*sent.station]) {
    const Asked& stop = ledger_.asked[id];
    const bool is_between = stop.given > asked.given && stop.given < sent.begin &&
                            ledger_.connections[stop.connection].process == ledger_.process;
    if (is_between && !stop.intent.refused && !stop.withdrawn && asked.answers == 0 &&
        !is_overfull(stop.connection, sent.begin)) {
      violation("after_its_stop", name(sent) + " for " + name(asked) + " stopped by " + name(stop));
      return;
    }
  }
}

}  // namespace mbgate::judge
