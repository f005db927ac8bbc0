// SPDX-License-Identifier: Apache-2.0
// What the oracle keeps of what happens.
#include "explore/oracle.hpp"

#include <algorithm>

namespace mbgate::explore {
namespace {

// As behaviour says where nothing is set.
Duration deadline_of(const Plant& plant, const Ask& ask) {
  const auto& route = plant.settings.routes.front();
  // Twice the longest ordinary transaction: 264 characters and the wait.
  const Duration wire = world::WireTimes(plant.bus().line).of(264);
  const Duration writes = 2 * (wire + plant.device().timing.response_timeout) + 500ms;
  return route.deadline.value_or(ask.is_read() ? std::max<Duration>(5s, writes) : writes);
}

}  // namespace

Oracle::Oracle(const Plant& plant)
    : plant_(plant),
      times_(plant.bus().line),
      silence_(world::silence_of(plant.bus())),
      slack_(world::slack_of(plant.bus())),
      hold_(world::quarantine_of(plant.device().timing) + kAdapterKeeps) {}

std::size_t Oracle::note_asked(const Ask& ask, Instant now) {
  const auto free = std::ranges::find(requests_, false, &Request::open);
  require(free != requests_.end(), "a slot for each request");
  *free = Request{.open = true, .ask = ask, .since = now, .deadline = Instant::max()};
  return static_cast<std::size_t>(free - requests_.begin());
}

void Oracle::note_taken(std::uint8_t client, Instant now) {
  for (Request& request : requests_) {
    const Ask& ask = request.ask;
    if (!request.open || request.taken || ask.client != client) {
      continue;
    }
    request.taken = true;
    request.event = ++events_;
    request.since = now;
    request.deadline = ask.word == Word::stop ? Instant::max() : now + deadline_of(plant_, ask);
    request.was_offline = is_offline(ask.device);
    request.repeats = is_repeated(request, now);
    request.must_follow = books_[ask.device].done;
    for (Request& other : requests_) {
      if (&other != &request && other.open && other.taken && !other.ask.is_read() &&
          !ask.is_read()) {
        ++other.rivals;
        ++request.rivals;
      }
    }
    if (ask.word == Word::stop) {
      cancel_writes(ask.device);
    }
  }
}

void Oracle::cancel_writes(std::uint8_t device) {
  for (Request& other : requests_) {
    if (other.open && other.taken && other.ask.device == device && other.ask.word == Word::write) {
      other.cancelled = other.cancelled || other.sent == 0;
    }
  }
}

bool Oracle::takes_part(const Request& request, const Flight& flight) const {
  const auto slot = static_cast<std::size_t>(&request - requests_.data());
  return request.open && request.taken && request.event < flight.event &&
         request.ask.device == flight.device && request.ask.word == flight.word &&
         (flight.word != Word::write || flight.value == kFirstValue + slot);
}

// It repeats a stop that was acknowledged, with nothing but stops since: it is no hurry.
bool Oracle::is_repeated(const Request& request, Instant now) const {
  const Book& book = books_[request.ask.device];
  return request.ask.word == Word::stop && book.is_stopped && now < book.stopped_at + kStopCounts;
}

// One is a retry of the other. No write is.
bool Oracle::is_same_request(const Flight& a, const Flight& b) const {
  return a.word == b.word && a.word != Word::write &&
         std::ranges::any_of(
             requests_, [&](const Request& it) { return takes_part(it, a) && takes_part(it, b); });
}

// What was transmitted and not answered holds back what comes after it.
void Oracle::end_running(Instant now, bool counts) {
  Flight& flight = *running();
  running_.reset();
  Book& book = books_[flight.device];
  is_disturbed_ = true;
  flight.spoilt = flight.spoilt || !counts;
  book.held_until = std::max(book.held_until, flight.due + hold_);
  book.stop_unanswered = counts && flight.word == Word::stop;
  const bool was_offline = is_offline(flight.device);
  book.unanswered += counts ? 1U : 0U;
  if (!is_offline(flight.device)) {
    return;
  }
  book.offline_at = was_offline ? book.offline_at : now;
  for (Request& request : requests_) {
    request.was_offline = request.was_offline || request.ask.device == flight.device;
  }
}

// Something that looks like its answer is waited for.
bool Oracle::is_waited_for(const Flight& flight) {
  const Flight* other = running();
  return other != nullptr && other->device == flight.device &&
         looks_alike(other->word, flight.word);
}

// What is on the wire has so long for its answer before a stop goes, or longer if its device has
// answered more slowly.
bool Oracle::is_cut_at(const Flight& running, Instant now) const {
  const auto is_stop = [](const Request& it) {
    return it.open && it.taken && it.ask.word == Word::stop;
  };
  return now >= running.left + plant_.bus().stop_wait && std::ranges::any_of(requests_, is_stop);
}

void Oracle::note_judged(Instant now) {
  Flight* flight = running();
  if (flight == nullptr || (flight->rest_comes && now < rest_end_of(*flight))) {
    return;
  }
  flight->cut = flight->cut || is_cut_at(*flight, now);
  if (now >= flight->due) {
    flight->perhaps ? end_uncertain() : end_running(now, true);
  }
}

// Nobody outside knows whether it was answered, or left unanswered.
void Oracle::end_uncertain() {
  books_[running()->device].stop_unanswered = true;
  running_.reset();
}

// Whatever is waited for that it may have been the answer to is not waited for any longer.
void Oracle::note_damaged(Flight& flight, Instant now) {
  flight.spoilt = true;
  is_disturbed_ = true;
  books_[flight.device].stop_unanswered = false;
  if (is_waited_for(flight)) {
    end_running(now, false);
  }
}

// It closes the oldest that it fits. If there is none, it is a second answer for all to see, where
// it fits what was answered last, and not what is waited for.
void Oracle::note_frame(Flight& flight, Instant now) {
  Book& book = books_[flight.device];
  book.last_heard = flight.event;
  book.heard_at = now;
  book.answers_twice = book.answers_twice || flight.heard;
  is_disturbed_ = is_disturbed_ || flight.heard;
  flight.heard = true;
  longest_answer_ = std::max(longest_answer_, now - flight.left);
  forget(flight.device, now - Duration{1});  // what came at the end of a tail came within it
  const auto fits = [&](const Flight& it) {
    return it.open && it.device == flight.device && looks_alike(it.word, flight.word) &&
           now >= it.left;
  };
  const auto open = std::ranges::find_if(flights_, fits);
  if (open != flights_.end()) {
    hold(*open, now);
  } else if (book.answered && looks_alike(flights_[*book.answered].word, flight.word) &&
             now <= book.answered_at + timing().response_timeout && !is_waited_for(flight)) {
    book.taught = book.taught == 0 ? ++events_ : book.taught;
    book.second_after = std::max(book.second_after, now - book.answered_at);
  }
}

// A device works in order, and may owe more than was counted. One that answers at once what was
// asked last has no queue.
void Oracle::hold(Flight& closed, Instant now) {
  const auto is_open = [&](const Flight& it) { return it.open && it.device == closed.device; };
  const Instant oldest = sent_at(*std::ranges::find_if(flights_, is_open));
  closed.open = false;
  Book& book = books_[closed.device];
  const auto count = std::ranges::count_if(flights_, is_open);
  const bool is_quick =
      running_ == closed.serial && now < closed.left + timing().response_timeout / 4;
  const auto had_no_time = [&](const Flight& it) {
    return is_open(it) && sent_at(it) >= book.forgets_at;
  };
  if (count == 0) {
    book.forgets_at = Instant::min();
  } else if (!is_quick || std::ranges::any_of(flights_, had_no_time)) {
    book.forgets_at = now + std::min<Duration>(2 * count * (now - oldest), timing().quarantine_max);
  }
  if (count == 0 || !is_quick) {
    book.owes_until = book.forgets_at;
  }
}

// What has not come when it was held for long enough is lost. A gateway may hold a device that owes
// nothing more, too, unless what it has not answered had been waited for before.
void Oracle::forget(std::uint8_t device, Instant now) {
  const Instant forgets_at = books_[device].forgets_at;
  for (Flight& flight : flights_) {
    const bool was_waited_for =
        now >= forgets_at && (flight.spoilt || sent_at(flight) < forgets_at);
    if (flight.device == device && now >= end_of_tail(flight) &&
        (was_waited_for || now >= sent_at(flight) + timing().quarantine_max)) {
      flight.open = false;
    }
  }
}

Instant Oracle::sent_at(const Flight& flight) const {
  return flight.left - times_.of(pdu_of(flight.word, flight.value).size() + 3);
}

void Oracle::note_heard(Flight& flight, Instant now) {
  note_frame(flight, now);
  Book& book = books_[flight.device];
  book.unanswered = 0;
  book.stop_unanswered = false;
  const bool was_written = std::ranges::any_of(flights_, [&](const Flight& it) {
    return it.device == flight.device && it.word == Word::write && it.event > flight.event;
  });
  if (flight.word == Word::stop && !was_written) {
    book.is_stopped = true;
    book.stopped_at = now;
    for (Request& it : requests_) {
      it.repeats = it.repeats || (it.open && it.taken && it.ask.device == flight.device);
    }
  }
  // What comes before a request has left answers another one, if only an earlier try: one stop is
  // as good as another.
  const auto is_as_good = [&](const Flight& it) {
    return is_same_request(flight, it) || (flight.word == Word::stop && it.word == Word::stop);
  };
  if (!is_waited_for(flight) || (now < running()->left && !is_as_good(*running()))) {
    return;
  }
  const Flight* waited_for = running();
  const bool owes_write = std::ranges::any_of(flights_, [&](const Flight& it) {
    return it.device == flight.device && it.word == Word::write && !it.heard &&
           it.event < waited_for->event;
  });
  const bool is_certain =
      waited_for->word != Word::stop || (flight.word != Word::write && !owes_write);
  flight.in_time = waited_for == &flight && !flight.cut && is_certain;
  if (waited_for != &flight) {  // nobody can tell, and the other one may still come
    book.held_until = std::max(book.held_until, waited_for->due + hold_);
    is_disturbed_ = true;
  }
  // Who knows that the answer to a write is owed takes none for that to a stop before.
  if (!is_certain) {
    running()->perhaps = true;
    return;
  }
  book.answered = waited_for->serial;
  book.answered_at = now;
  const Duration took = now - waited_for->left;
  if (book.shortest_answer != Duration::max() && took < book.shortest_answer * 7 / 8) {
    book.sudden_until = now + timing().response_timeout + kAdapterKeeps;
  }
  book.shortest_answer = std::min(book.shortest_answer, took);
  running_.reset();
}

void Oracle::add_edges(std::vector<Instant>& edges, bool may_be_asked) const {
  for (const Request& request : requests_) {
    if (request.open && request.taken && request.ask.word != Word::stop) {
      edges.push_back(request.deadline);
    }
  }
  if (!may_be_asked) {
    return;
  }
  for (const Book& book : books_) {
    edges.push_back(book.held_until);
    if (book.offline_at != Instant::min()) {
      edges.push_back(book.offline_at + timing().probe_interval);
    }
  }
  if (!is_running()) {
    edges.push_back(silent_at());
  }
}

}  // namespace mbgate::explore
