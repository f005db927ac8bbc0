// SPDX-License-Identifier: Apache-2.0
// What the oracle asks of a gateway that is told to stop: what is on the wire ends, stops go, the
// rest is told at once.
#include "soak/oracle.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

namespace {

constexpr Duration kLatestEnd = 600ms;  // that the process may be
constexpr int kFewStops = 3;            // there is time for so many

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
  // Nobody waits any more for a line that is away.
  for (const auto& [id, asked] : open_) {
    const std::size_t bus = asked->failsafe ? asked->pieces.front().bus : 0;
    const bool is_away = !books_[bus].open && !books_[bus].starting && !is_tcp(bus);
    asked->dropped = asked->dropped || (asked->failsafe && asked->flights == 0 && is_away);
  }
  for (auto& [client, session] : sessions_) {
    accept_backlog(session);
  }
}

// Nobody cuts an answer that has begun, or a request that is being sent, or sends before a silence:
// that may last until the end, and keep the line from the failsafe writes that are left. That none
// waited while the wire was idle is judged elsewhere.
void Oracle::finished() {
  finished_ = true;
  if (!stopping_ || schedule_.now() > *stopping_ + kGrace + kLatestEnd) {
    violation("finished_late", "the gateway");
    return;
  }
  const auto is_busy = [&](const Book& book) {
    const Flight* last = flight(book.last_flight);
    if (last == nullptr || is_tcp(last->bus)) {
      return false;
    }
    const auto& settings = bus_settings(last->bus);
    const bool is_silent = schedule_.now() > book.last_byte + spec::silence_of(settings);
    if (schedule_.now() <= last->end + settings.stop_wait + lateness() ||
        (!is_silent && schedule_.now() < *stopping_ + stop_deadline(last->bus))) {
      return true;
    }
    if (book.came == 0) {
      return false;
    }
    const Duration pause =
        settings.line.framing == bus::Framing::ascii ? 1s : spec::slack_of(settings);
    return book.use.first_read < last->due &&
           schedule_.now() <= book.use.first_read + rest_of_answer(*last) &&
           schedule_.now() <= book.last_handed_in + pause + spec::silence_of(settings);
  };
  for (const auto& [id, asked] : open_) {
    if (!asked->failsafe || asked->accepted != *stopping_ || asked->flights > 0) {
      continue;
    }
    const std::size_t bus = asked->pieces.front().bus;
    const Book& book = books_[bus];
    const bool is_late =
        book.stops_at_end > 0 && book.first_stop_at_end > *stopping_ + kGrace / kFewStops;
    const bool could_go = book.open && book.last_down < *stopping_ &&
                          book.stops_at_end <= kFewStops && !is_late &&
                          plan_.rates[bus].babbles_every == Duration{0};
    if (could_go && !is_busy(book)) {
      violation("failsafe_missing", name(*asked) + " at the end");
    }
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
