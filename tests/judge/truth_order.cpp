// SPDX-License-Identifier: Apache-2.0
// With `ordered = true` a connection gets its answers in the order of its requests; without it
// identifiers suffice.
#include <algorithm>

#include "judge/rules_judge.hpp"

namespace mbgate::judge {

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
