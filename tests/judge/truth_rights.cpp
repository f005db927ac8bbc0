// SPDX-License-Identifier: Apache-2.0
// What is denied gets 01 and goes nowhere (judge.cpp, truth_writes.cpp see to the latter); what
// waits for a right that a reload has taken gets 06, and does not go any more.
#include <algorithm>

#include "judge/rules_judge.hpp"

namespace mbgate::judge {

namespace {
constexpr std::uint8_t kNoRight = 0x01;
constexpr std::uint8_t kBusy = 0x06;
}  // namespace

void RulesJudge::check_denied(const Asked& asked) {
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

}  // namespace mbgate::judge
