// SPDX-License-Identifier: Apache-2.0
// A broadcast goes out in every form that is used on its buses; and the order of answers.
#include <algorithm>

#include "judge/rules_judge.hpp"

namespace mbgate::judge {

void RulesJudge::check_forms(const Asked& asked) {
  if (asked.intent.kind != Kind::broadcast || asked.answer[0] >= 0x80) {
    return;
  }
  for (const Station& station : plan_.stations) {
    const auto form = plan_.settings.devices[*station.device].profile.broadcast.form;
    const bool is_meant =
        std::ranges::count(asked.intent.buses, station.bus) > 0 && form != std::nullopt;
    const bool was_sent = std::ranges::any_of(asked.sent, [&](Id id) {
      const Sent& sent = ledger_.sent[id];
      return sent.bus == station.bus && sent.has_other_form == station.other_broadcasts;
    });
    if (is_meant && !was_sent) {
      violation("form_missing", asked, "on " + plan_.bus(station.bus).name);
      return;
    }
  }
}

// With `ordered = true` a connection gets its answers in the order of its requests; without it
// identifiers suffice.
void RulesJudge::note_due(Id id) {
  const Asked& asked = ledger_.asked[id];
  const auto& listener = plan_.settings.listeners[connection_of(asked).listener];
  const bool answers_all = listener.give_up == Duration{0} && !listener.one_at_a_time;
  if (listener.ordered && answers_all && asked.intent.answer_due) {
    due_[asked.connection].push_back(id);
  }
}

void RulesJudge::check_order(Id id) {
  const Asked& asked = ledger_.asked[id];
  const auto found = due_.find(asked.connection);
  // One that is not replied to gets its refusal all the same, at any time.
  if (found == due_.end() || std::ranges::count(found->second, id) == 0) {
    return;
  }
  if (found->second.front() != id) {
    violation("out_of_order", asked);
  }
  std::erase(found->second, id);
}

}  // namespace mbgate::judge
