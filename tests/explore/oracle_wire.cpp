// SPDX-License-Identifier: Apache-2.0
// What may be transmitted, and when.
#include <algorithm>

#include "explore/oracle.hpp"

namespace mbgate::explore {

std::optional<Flight> Oracle::understand(const Octets& frame, Instant now) {
  const auto adu = world::read_rtu(frame);
  if (!adu || adu->address < 1 || adu->address > kDevices) {
    return std::nullopt;
  }
  Flight flight;
  flight.serial = static_cast<std::uint16_t>(flights_.size());
  flight.device = static_cast<std::uint8_t>(adu->address - 1U);
  flight.event = events_ + 1;
  flight.left = flight.begins = now + times_.of(frame.size());
  const Duration timeout =
      is_offline(flight.device) ? world::probe_timeout_of(timing()) : timing().response_timeout;
  flight.due = flight.left + timeout;
  for (const Word word : {Word::read_a, Word::read_b, Word::stop}) {
    if (adu->pdu == pdu_of(word, 0)) {
      flight.word = word;
      return flight;
    }
  }
  for (std::uint16_t value = kFirstValue; value < kFirstValue + kSlots; ++value) {
    if (adu->pdu == pdu_of(Word::write, value)) {
      flight.word = Word::write;
      flight.value = value;
      return flight;
    }
  }
  return std::nullopt;
}

void Oracle::note_transmitted(const Octets& frame, Instant now) {
  const auto flight = understand(frame, now);
  if (!flight) {
    report("transmitted: nothing that anybody asked for");
    return;
  }
  if (now < silent_at()) {
    report("silence: transmitted before t3.5 was over");
  }
  check_overlap(now);
  check_hold(*flight, now);
  check_stops_first(*flight, now);
  check_asked_for(*flight, now);
  ++events_;
  for (Request& request : requests_) {
    request.sent += takes_part(request, *flight) ? 1U : 0U;
  }
  Book& book = books_[flight->device];
  book.is_stopped = book.is_stopped && flight->word != Word::write;
  flights_.push_back(*flight);
  running_ = flight->serial;
  quiet_ = flight->left;
}

// One at a time; a stop need not wait for longer than is_cut_at(). Then it goes, or what it gives
// way to.
void Oracle::check_overlap(Instant now) {
  if (running() == nullptr) {
    return;
  }
  if (running()->perhaps) {
    end_uncertain();
    return;
  }
  if (!is_cut_at(*running(), now)) {
    report("overlap: transmitted while an answer is waited for");
  }
  cut_ = running()->serial;
  end_running(now, true);
}

// A device that may still answer an earlier request, or once more, is left alone, but for stops and
// the retry of the same read. Another function may go to one that has answered since.
void Oracle::check_hold(const Flight& flight, Instant now) {
  const auto is_tried_again = [&](const Flight& it) { return is_same_request(it, flight); };
  if (flight.word == Word::stop || std::ranges::any_of(flights_, is_tried_again)) {
    return;
  }
  const Book& book = books_[flight.device];
  for (const Flight& owed : flights_) {
    if (owed.device != flight.device) {
      continue;
    }
    if (book.heard_at < owed.left && book.answered != owed.serial && now < end_of_tail(owed)) {
      report("hold: transmitted while an answer is owed");
    } else if (owed.open && looks_alike(owed.word, flight.word) && now < book.owes_until) {
      report("hold: transmitted while a slow device may owe more");
    }
  }
  const Duration second = book.second_after + book.second_after / 4 + kAdapterKeeps;
  if (book.taught > 0 && now < book.answered_at + std::min(second, timing().response_timeout)) {
    report("hold: transmitted while a second answer may come");
  }
}

void Oracle::check_stops_first(const Flight& flight, Instant now) {
  if (flight.word == Word::stop) {
    return;
  }
  for (const Request& stop : requests_) {
    if (!stop.open || !stop.taken || stop.ask.word != Word::stop || stop.sent > 0 ||
        is_repeated(stop, now)) {
      continue;
    }
    const Book& book = books_[stop.ask.device];
    // A read may come between the tries of a stop to a device that does not answer, and so may
    // what is for another device.
    const bool gives_way = (book.stop_unanswered || book.unanswered > 0) &&
                           (flight.word != Word::write || flight.device != stop.ask.device);
    if (!gives_way) {
      report("stop overtaken");
    }
  }
}

void Oracle::check_asked_for(const Flight& flight, Instant now) {
  bool is_asked = false;
  bool in_time = flight.word == Word::stop;
  for (const Request& request : requests_) {
    if (!takes_part(request, flight)) {
      continue;
    }
    is_asked = true;
    in_time = in_time || now <= request.deadline;
    if (request.cancelled) {
      report("cancelled write: transmitted after its stop");
    }
    if (flight.word == Word::write && request.sent > 0) {
      report("write twice");
    }
  }
  if (!is_asked) {
    report("transmitted for nobody");
  } else if (!in_time) {
    report("late command: transmitted after its deadline");
  }
}

}  // namespace mbgate::explore
