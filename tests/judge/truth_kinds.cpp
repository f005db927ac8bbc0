// SPDX-License-Identifier: Apache-2.0
// What names no register is answered by that drive, and a broadcast goes out in every form that is
// used on its buses; and the order of answers.
#include <algorithm>

#include "judge/rules_judge.hpp"

namespace mbgate::judge {

// Those answers end in the drive's first input registers, which no other drive has. How old they
// may be truth_answers asks of others.
void RulesJudge::check_odd_read(const Asked& asked) {
  constexpr Duration kOld = 12s;
  constexpr std::size_t kData = 4;
  const Octets& answer = asked.answer;
  if (!asked.intent.is_odd_read || answer[0] >= 0x80 || answer[0] == 0x07) {
    return;
  }
  const auto& drives = plan_.stations[*asked.intent.station].drives;
  const Span span{asked.given - kOld, world_.now()};
  const bool is_its = answer.size() > kData && std::ranges::any_of(drives, [&](std::size_t drive) {
                        const Registers& registers = world_.drives()[drive].registers();
                        const std::uint16_t first = word_at(answer, answer.size() - kData);
                        const std::uint16_t second = word_at(answer, answer.size() - kData + 2);
                        return registers.held(Table::input_registers, 0, {&first, 1}, span) &&
                               registers.held(Table::input_registers, 1, {&second, 1}, span);
                      });
  if (!is_its) {
    violation("odd_value", asked);
  }
}

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
