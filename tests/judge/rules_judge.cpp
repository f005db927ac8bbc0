// SPDX-License-Identifier: Apache-2.0
#include "judge/rules_judge.hpp"

namespace mbgate::judge {

void RulesJudge::violation(const char* kind, const Asked& asked, const std::string& why) {
  const Connection& connection = connection_of(asked);
  report_.violation(kind, "at " + std::to_string(world_.now().time_since_epoch() / 1us) +
                              " us: host " + std::to_string(connection.host) + " on " +
                              plan_.settings.listeners[connection.listener].name + " client " +
                              std::to_string(asked.connection) + " transaction " +
                              std::to_string(asked.transaction) + " unit " +
                              std::to_string(asked.intent.unit) + " pdu " + hex(asked.intent.pdu) +
                              " given " + std::to_string(asked.given.time_since_epoch() / 1us) +
                              (asked.answers > 0 ? " answer " + hex(asked.answer) : "") +
                              (why.empty() ? "" : ", " + why));
}

void RulesJudge::given(Id id) {
  open_.insert(id);
  recent_[connection_of(ledger_.asked[id]).host].push_back(id);
  note_due(id);
  note_write(ledger_.asked[id]);
  next_.given(id);
}

void RulesJudge::gone(Id connection) {
  std::erase_if(open_, [&](Id id) { return ledger_.asked[id].connection == connection; });
  due_.erase(connection);
  next_.gone(connection);
}

void RulesJudge::answered(Id id) {
  const Asked& asked = ledger_.asked[id];
  check_denied(asked);
  check_order(id);
  check_forms(asked);
  check_busy(asked);
  note_gone_through(asked);
  open_.erase(id);
  next_.answered(id);
}

void RulesJudge::sent(Id id) {
  const Sent& sent = ledger_.sent[id];
  check_withdrawn(sent);
  check_writer(sent);
  next_.sent(id);
}

}  // namespace mbgate::judge
