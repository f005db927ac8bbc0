// SPDX-License-Identifier: Apache-2.0
// What the oracle asks of a gateway that is told to stop: what is on the wire ends, stops go, the
// rest is told at once.
#include "soak/oracle.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

namespace {

constexpr Duration kLatestEnd = 600ms;  // that the process may be

}  // namespace

void Oracle::begin_shutdown() {
  stopping_ = schedule_.now();
  for (auto& [client, session] : sessions_) {
    accept_backlog(session);
  }
}

void Oracle::finished() {
  finished_ = true;
  if (!stopping_ || schedule_.now() > *stopping_ + kGrace + kLatestEnd) {
    violation("finished_late", "the gateway");
  }
}

void Oracle::check_stopped() {
  if (!finished_) {
    violation("not_finished", "the gateway");
  }
  for (const auto& [client, session] : sessions_) {
    for (const auto& [transaction, id] : session.by_transaction) {
      const Asked& asked = *open_.at(id);
      if (asked.is_accepted && asked.replies) {
        violation("unanswered", name(asked) + " before the end");
      }
    }
  }
}

}  // namespace mbgate::soak
