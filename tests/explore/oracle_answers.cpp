// SPDX-License-Identifier: Apache-2.0
// What clients may be told, and until when.
#include <algorithm>

#include "explore/oracle.hpp"

namespace mbgate::explore {

void Oracle::note_sent(std::uint8_t client, const Octets& adu, Instant now) {
  constexpr std::size_t kHeader = 7;
  constexpr std::uint8_t kException = 0x80;
  constexpr std::uint8_t kBusy = 0x06;
  constexpr std::uint8_t kNoAnswer = 0x0B;
  const std::size_t slot = adu.size() > kHeader ? world::word_at(adu, 0) : kSlots;
  if (slot >= kSlots || !requests_[slot].open || !requests_[slot].taken ||
      requests_[slot].ask.client != client) {
    report("an answer to nothing that the client has asked");
    return;
  }
  Request& request = requests_[slot];
  const Octets pdu(adu.begin() + kHeader, adu.end());
  const std::uint8_t function = pdu_of(request.ask.word, 0).front();
  if (adu[6] != request.ask.device + 1 || world::word_at(adu, 2) != 0 ||
      world::word_at(adu, 4) != pdu.size() + 1) {
    report("the header of an answer");
  } else if (pdu.front() == function && request.ask.is_read()) {
    check_read(request, pdu, now);
  } else if (pdu.front() == function) {
    check_write(request);
  } else if (pdu.front() != (function | kException) || pdu.size() != 2) {
    report("an answer of another function");
  } else if (pdu[1] == kBusy) {
    check_busy(request, now);
  } else if (pdu[1] == kNoAnswer) {
    check_no_answer(request);
  } else {
    report("an exception that nobody has made");
  }
  request.open = false;
}

// It shows the register asked for, as it was after the request came, or was remembered for it.
void Oracle::check_read(const Request& request, const Octets& pdu, Instant /*now*/) {
  const std::size_t serial = pdu.size() == 6 ? world::word_at(pdu, 2) : flights_.size();
  if (serial >= flights_.size() || !flights_[serial].heard ||
      world::word_at(pdu, 4) != tag_of(request.ask.device, request.ask.word)) {
    note_wrong(request.ask.device, "misdelivered: another answer than that to the read");
    return;
  }
  const Flight& flight = flights_[serial];
  const Duration cache = plant_.device().cache;
  const bool is_remembered = cache > Duration{0} && flight.left >= request.since - cache &&
                             flight.event > request.must_follow;
  if (flight.event < request.event && !is_remembered) {
    note_wrong(request.ask.device, "misdelivered: an answer from before the request");
  }
}

// A second answer to what was sent before one was seen to be one may be taken for another answer,
// and that one for the next.
void Oracle::note_wrong(std::uint8_t device, const char* what) {
  const Book& book = books_[device];
  if (book.answers_twice && (book.taught == 0 || book.last_heard < book.taught)) {
    ++learning_;
  } else {
    report(what);
  }
}

void Oracle::check_write(const Request& request) {
  const auto done = std::ranges::find_if(
      flights_, [&](const Flight& flight) { return takes_part(request, flight) && flight.heard; });
  Book& book = books_[request.ask.device];
  // The same stop a moment ago is as good: nothing has set the device going since.
  if (request.ask.word == Word::stop && request.sent > 0 && book.is_stopped) {
    return;
  }
  if (done == flights_.end()) {
    note_wrong(request.ask.device, "misdelivered: acknowledged, and no answer to it was heard");
    return;
  }
  book.done = std::max(book.done, done->event);
}

// Never transmitted; and its deadline is over, a stop took it back, or its device is offline.
void Oracle::check_busy(const Request& request, Instant now) {
  const bool is_late = now >= request.deadline;
  if (request.ask.word == Word::stop) {
    report("06 to a stop");
  } else if (request.ask.word == Word::write && request.sent > 0) {
    report("06 though it was transmitted");
  } else if (!is_late && !request.cancelled && !(request.was_offline && !request.ask.is_read())) {
    report("06 without a reason");
  }
}

// It was transmitted, and no answer to it came in time.
void Oracle::check_no_answer(const Request& request) {
  const auto last = std::find_if(flights_.rbegin(), flights_.rend(),
                                 [&](const Flight& flight) { return takes_part(request, flight); });
  if (request.ask.is_read() && request.was_offline) {
    return;
  }
  if (last == flights_.rend()) {
    report("0B though it was never transmitted");
  } else if (last->in_time && !is_disturbed()) {  // else it may belong to an earlier one
    report("0B though its answer came in time");
  }
}

void Oracle::note_passing(Instant now, bool is_undisturbed) {
  for (const Request& request : requests_) {
    if (request.open && request.taken) {
      check_waiting(request, now);
      const bool may_go = running() == nullptr && now >= silent_at() &&
                          now >= books_[request.ask.device].sudden_until;
      if (is_undisturbed && !is_disturbed_ && may_go) {
        report("needlessly late: the line is silent, and a request waits");
      }
    }
  }
}

void Oracle::check_waiting(const Request& request, Instant now) {
  constexpr Duration kFrames = 25ms;  // a request, its answer, and the silences around them
  constexpr Duration kDelay = 600ms;  // that the driver may add
  const Duration timeout = timing().response_timeout + slack_ + kFrames;
  const Duration delay = (has_slept_ ? kDelay : Duration{0}) +
                         (request.repeats ? kStopCounts + request.rivals * timeout : Duration{0});
  if (request.cancelled) {
    report("taken back by a stop, and not answered");
  }
  if (request.ask.word != Word::stop) {
    require(now < request.since + kAnsweredBy || request.deadline < request.since + kAnsweredBy,
            "requests are answered long before a far deadline");
    if (now > request.deadline + timeout + delay) {
      report("unanswered: long after its deadline");
    }
    return;
  }
  // A stop waits for a running answer twice as long as such a device has needed.
  const Duration learned = std::min(2 * longest_answer_, timing().response_timeout);
  const Duration cut = std::max(plant_.bus().stop_wait, learned) + slack_ + kFrames;
  if (request.sent == 0 && now > request.since + request.rivals * cut + delay) {
    report("a stop waits for too long");
  }
  const int tries = 1 + static_cast<int>(timing().stop_retries);
  if (now > request.since + request.rivals * tries * (timeout + cut) + delay) {
    report("unanswered: a stop, after all its tries");
  }
}

void Oracle::note_end() {
  if (std::ranges::any_of(requests_, &Request::open)) {
    report("unanswered, and nothing will ever happen");
  }
}

}  // namespace mbgate::explore
