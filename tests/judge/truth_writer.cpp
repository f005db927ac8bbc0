// SPDX-License-Identifier: Apache-2.0
// Where `writer = "first"` says so, nobody writes for `writer_hold` after another client's write;
// stops always go. What lists of writers say is a right (world/rights).
#include "judge/rules_judge.hpp"

namespace mbgate::judge {

using gateway::WriterRule;

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
    if (guard.writer == WriterRule::first && is_owner) {
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
  if (guard.writer != WriterRule::first) {
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
