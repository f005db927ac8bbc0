// SPDX-License-Identifier: Apache-2.0
// What is denied gets 01 and goes nowhere (judge.cpp, truth_writes.cpp see to the latter); what
// waits for a right that a reload has taken gets 06, and does not go any more.
#include <algorithm>

#include "judge/rules_judge.hpp"

namespace mbgate::judge {

void RulesJudge::check_denied(const Asked& asked) {
  constexpr std::uint8_t kNoRight = 0x01;
  constexpr std::uint8_t kBusy = 0x06;
  const std::uint8_t code = asked.answer.size() == 2 ? asked.answer[1] : 0;
  // What came before a reload is perhaps not understood any more; and it counts from when its
  // socket was last seen empty.
  const bool is_plain =
      ledger_.reloaded < connection_of(asked).opened && ledger_.stopping == kNever;
  if (asked.intent.denied && is_plain && code == kBusy && (asked.intent.codes >> kBusy & 1U) == 0) {
    violation("denied_as_if_busy", asked);
  }
  const auto station = asked.intent.station;
  // Where answers wait for others it may have been decided before.
  const bool is_ordered = plan_.settings.listeners[connection_of(asked).listener].ordered;
  if (!asked.withdrawn || !asked.sent.empty() || asked.intent.kind == Kind::read || !station ||
      is_ordered) {
    return;
  }
  const LineBook& line = ledger_.lines[plan_.stations[*station].bus];
  const bool was_closed = !line.open || line.opened >= asked.given || line.closed >= asked.given;
  if (code != kBusy && code != kNoRight && !was_closed) {
    violation("withdrawn_otherwise", asked);
  }
}

void RulesJudge::check_withdrawn(const Sent& sent) {
  if (sent.asked.empty() || sent.is_stop || sent.cells.empty()) {
    return;
  }
  const Asked& asked = ledger_.asked[sent.asked.front()];
  if (asked.withdrawn && asked.sent.size() == 1) {
    violation("sent_without_right", asked);
  }
}

// Where `writer = "first"` says so, nobody writes for `writer_hold` after another client's write;
// stops always go. What lists of writers say is a right (world/rights).
void RulesJudge::note_write(const Asked& asked) {
  const unsigned host = connection_of(asked).host;
  if (asked.intent.station && asked.intent.kind == Kind::write) {
    wanted_[*asked.intent.station][host] = world_.now();
  }
  for (const std::size_t bus : asked.intent.buses) {
    broadcast_[bus] = world_.now();
  }
}

// Whoever was sent for was accepted, at the latest then, and not before it was given.
void RulesJudge::check_writer(const Sent& sent) {
  if (sent.asked.empty() || !sent.station || sent.cells.empty()) {
    return;
  }
  const Asked& asked = ledger_.asked[sent.asked.front()];
  const Station& station = plan_.stations[*sent.station];
  if (asked.intent.kind != Kind::write || asked.sent.size() != 1 || !station.device) {
    return;
  }
  const gateway::DeviceGuard& guard = plan_.settings.guards[*station.device];
  const unsigned host = connection_of(asked).host;
  auto& written = written_[*sent.station];
  for (const auto& [other, last] : written) {
    const bool is_owner = other != host && last.process == ledger_.process &&
                          last.sent < asked.given && last.given > ledger_.reloaded &&
                          world_.now() < last.given + guard.writer_hold;
    if (guard.writer == gateway::WriterRule::first && is_owner) {
      violation("not_the_writer", asked, "host " + std::to_string(other) + " has written");
    }
  }
  written[host] = {asked.given, world_.now(), ledger_.process};
}

bool RulesJudge::may_be_owned(const Asked& asked) const {
  const std::size_t station = *asked.intent.station;
  const auto device = plan_.stations[station].device;
  const gateway::DeviceGuard& guard = plan_.settings.guards[*device];
  const unsigned host = connection_of(asked).host;
  const auto by_all = broadcast_.find(plan_.stations[station].bus);
  if (guard.writer != gateway::WriterRule::first) {
    return false;
  }
  if (by_all != broadcast_.end() && by_all->second + guard.writer_hold >= asked.given) {
    return true;
  }
  const auto found = wanted_.find(station);
  return found != wanted_.end() && std::ranges::any_of(found->second, [&](const auto& entry) {
           return entry.first != host && entry.second + guard.writer_hold >= asked.given;
         });
}

}  // namespace mbgate::judge
