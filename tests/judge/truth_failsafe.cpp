// SPDX-License-Identifier: Apache-2.0
// Failsafe writes go when a client that has written to the drive has gone, and not while all of
// them are there; they stay due until the drive has them.
#include <algorithm>

#include "judge/judge.hpp"

namespace mbgate::judge {

// A host that has written: since when is it gone, for this drive? Connections that ask it nothing
// do not count. kNever: it is there.
Instant Judge::gone_since(unsigned host, std::size_t station) const {
  const auto found = askers_.find({host, station});
  Instant last = Instant::min();
  if (found == askers_.end()) {
    return kNever;
  }
  for (const auto& [id, is_known] : found->second) {
    const Connection& connection = ledger_.connections[id];
    if (connection.process == ledger_.process && (is_known || connection.gone != kNever)) {
      last = std::max(last, connection.gone);  // kNever is the latest of all
    }
  }
  return last == Instant::min() ? kNever : last;
}

void Judge::note_asked_of(const Asked& asked) {
  const auto station = asked.intent.station;
  if (!station || asked.given == kNever) {
    return;
  }
  const unsigned host = ledger_.connections[asked.connection].host;
  // What was refused at once has asked nothing.
  const bool is_known = asked.answers > 0 && asked.answer[0] < 0x80;
  bool& known = askers_[{host, *station}][asked.connection];
  known = known || is_known;
  if (asked.intent.kind == Kind::write && !asked.intent.refused) {
    wrote_[*station][host] = ledger_.process;
  }
}

void Judge::check_failsafe(const Sent& sent) {
  const Station& station = plan_.stations[*sent.station];
  const gateway::DeviceGuard& guard = plan_.settings.guards[*station.device];
  // Broadcasts write too, and silence may be a reason; and what was just asked may not be known.
  if (guard.quiet > 0ms || has_broadcast_ || ledger_.stopping != kNever) {
    return;
  }
  const bool is_wanted = std::ranges::any_of(wrote_[*sent.station], [&](const auto& entry) {
    const auto& [host, process] = entry;
    return process == ledger_.process && gone_since(host, *sent.station) != kNever;
  });
  if (!is_wanted) {
    violation("failsafe_unwanted", name(sent));
  }
}

// Everybody has left, and every drive is well.
void Judge::check_failsafe_done() {
  const Cell stop{Table::holding_registers, kFailsafeRegister, kFailsafeWord};
  std::vector<Instant> written(plan_.stations.size(), Instant::min());
  for (const Done& done : ledger_.done) {
    const Sent& sent = ledger_.sent[done.sent];
    const bool is_clients =
        sent.station && !sent.is_failsafe && !sent.is_stop && sent.process == ledger_.process;
    const bool is_known = is_clients && std::ranges::any_of(sent.asked, [&](Id id) {
                            return !ledger_.asked[id].intent.refused;
                          });
    if (is_known) {
      written[*sent.station] = std::max(written[*sent.station], sent.begin);
    }
  }
  for (std::size_t at = 0; at < plan_.stations.size(); ++at) {
    const Station& station = plan_.stations[at];
    if (!plan_.has_failsafe(station) || written[at] == Instant::min()) {
      continue;
    }
    const auto found = ledger_.doers.find(key_of(at, stop));
    const bool is_done =
        found != ledger_.doers.end() && std::ranges::any_of(found->second, [&](Id done) {
          return ledger_.done[done].at > written[at];
        });
    if (!is_done) {
      violation("failsafe_missing",
                plan_.bus(station.bus).name + " address " + std::to_string(station.address));
    }
  }
}

}  // namespace mbgate::judge
