// SPDX-License-Identifier: Apache-2.0
// What of the oracle's knowledge decides something later.
#include <algorithm>

#include "explore/oracle.hpp"

namespace mbgate::explore {

bool Oracle::is_live(const Flight& flight) const {
  const bool may_be_remembered =
      plant_.device().cache > Duration{0} && flight.heard && Ask{.word = flight.word}.is_read();
  return flight.outstanding || flight.rest_comes || running_ == flight.serial || flight.open ||
         may_be_remembered ||
         std::ranges::any_of(requests_, [&](const Request& it) { return takes_part(it, flight); });
}

void Oracle::read(StateHash& hash) const {
  for (const Request& request : requests_) {
    hash.add(request.open);
    if (!request.open) {
      continue;
    }
    const auto& [open, taken, cancelled, repeats, was_offline, ask, event, since, deadline, sent,
                 rivals, must_follow] = request;
    for (const bool flag : {taken, cancelled, repeats, was_offline}) {
      hash.add(flag);
    }
    hash.add(ask.client);
    hash.add(ask.device);
    hash.add(ask.word);
    hash.ordered(Order::event, event);
    hash.ordered(Order::event, plant_.device().cache > Duration{0} ? must_follow : 0);
    hash.add(sent);
    if (ask.word == Word::stop) {
      hash.add(rivals);
      hash.since(since, kFarPast);
    } else if (taken) {
      hash.deadline(deadline, since);
    }
  }
  for (const Flight& flight : flights_) {
    if (is_live(flight)) {
      read(flight, hash);
    }
  }
  std::ranges::for_each(books_, [&](const Book& book) { read(book, hash); });
  hash.since(quiet_, silence_ + Duration{1});
  hash.add(std::min(longest_answer_, timing().response_timeout));
}

void Oracle::read(const Flight& flight, StateHash& hash) const {
  const auto& [serial, device, word, value, event, left, due, begins, outstanding, late, spoilt,
               heard, open, cut, in_time, perhaps, first_at, half_at, rest_comes] = flight;
  hash.add(plant_.device().cache > Duration{0} ? serial : 0);
  hash.add(device);
  hash.add(word);
  hash.add(value);
  hash.ordered(Order::event, event);
  for (const bool flag : {outstanding, late, spoilt, heard, open, cut, in_time, perhaps, rest_comes,
                          running_ == serial}) {
    hash.add(flag);
  }
  if (rest_comes) {
    hash.since(*half_at, kFarPast);
  }
  if (outstanding) {
    hash.since(begins, kFarPast);
    hash.since(first_at.value_or(Instant::min()), kFarPast);
  }
  if (outstanding || running_ == serial || open) {
    hash.since(left, kFarPast);
    hash.since(due, kFarPast);
  } else if (plant_.device().cache > Duration{0}) {
    hash.since(left, plant_.device().cache);
  }
}

void Oracle::read(const Book& book, StateHash& hash) const {
  const auto& [held_until, stop_unanswered, unanswered, offline_at, is_stopped, stopped_at, done,
               answered, answered_at, shortest_answer, sudden_until, heard_at, owes_until,
               forgets_at, last_heard, answers_twice, taught, second_after] = book;
  hash.add(answered ? flights_[*answered].word : Word::read_a);
  hash.since(answered_at, timing().response_timeout + Duration{1});
  hash.add(answers_twice);
  hash.ordered(Order::event, taught);
  hash.add(second_after);
  hash.add(is_stopped);
  hash.since(stopped_at, kStopCounts);
  hash.add(shortest_answer);
  hash.until(sudden_until);
  hash.since(heard_at, kFarPast);
  hash.since(owes_until, kFarPast);
  hash.since(forgets_at, kFarPast);
  hash.until(held_until);
  hash.add(stop_unanswered);
  hash.add(timing().offline_after != 0 ? unanswered : 0);
  hash.since(offline_at, timing().probe_interval + Duration{1});
  hash.ordered(Order::event, plant_.device().cache > Duration{0} ? done : 0);
}

}  // namespace mbgate::explore
