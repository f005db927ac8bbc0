// SPDX-License-Identifier: Apache-2.0
// What the oracle asks of a gateway that is told to stop: what is on the wire ends, stops go, the
// rest is told at once.
#include "soak/oracle.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

namespace {

constexpr Duration kLatestEnd = 600ms;  // that the process may be
constexpr std::size_t kFewStops = 3;    // there is time for so many

}  // namespace

void Oracle::begin_shutdown() {
  begin_failsafe();
  for (Asked& due : failsafe_.take_at_exit(schedule_.now())) {
    due.id = ++ids_;
    ++failsafes_;
    const auto entry = open_.emplace(due.id, std::make_unique<Asked>(std::move(due))).first;
    accept(*entry->second);
  }
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
  for (const auto& [id, asked] : open_) {
    const std::size_t bus = asked->failsafe ? asked->pieces.front().bus : 0;
    const Book& book = books_[bus];
    const bool could_go = book.open && book.last_down < *stopping_ &&
                          book.stops_at_end <= kFewStops &&
                          plan_.rates[bus].babbles_every == Duration{0};
    if (asked->failsafe && asked->accepted == *stopping_ && asked->flights == 0 && could_go) {
      violation("failsafe_missing", name(*asked) + " at the end");
    }
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
