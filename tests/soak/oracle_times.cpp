// SPDX-License-Identifier: Apache-2.0
// How late the process may be, and which answer was surely taken.
#include <algorithm>

#include "soak/heard_answers.hpp"
#include "soak/oracle.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

namespace {

constexpr Duration kLongestLate = 20ms;
constexpr Duration kLongestStall = 520ms;
constexpr Duration kStop = 1520ms;

}  // namespace

// The process may come so late to what is due.
Duration Oracle::lateness() const {
  const DriverManners& driver = plan_.driver;
  return 1ms + driver.usual + (driver.late > 0 ? kLongestLate : 0ms) +
         (driver.slow > 0 ? kLongestLate : 0ms) +
         (driver.stops    ? kStop
          : driver.stalls ? kLongestStall
                          : 0ms);
}

void Oracle::note_whole(std::size_t bus, HeardFrame& frame) const {
  const Book& book = books_[bus];
  frame.ended = schedule_.now();
  frame.came = book.came;
  frame.is_only_debt = is_only_debt(book.lanes[frame.address], frame);
}

// The answer to what was transmitted last.
void Oracle::note_answered(std::size_t bus, const HeardFrame& frame) {
  Book& book = books_[bus];
  Flight* last = flight(book.last_flight);
  if (last == nullptr || last->number != frame.flight || !frame.fits || frame.is_nobodys) {
    return;
  }
  last->unsure = HeardAnswers(*this).why_unsure(*last, frame);
  if (last->unsure == nullptr || last->unsure == kBesideStop) {
    book.use.fitting = schedule_.now();
  }
  if (last->unsure != nullptr) {
    return;
  }
  last->is_answered = true;
  last->needs_silence = frame.lead > 0;
  book.use.is_answered = book.use.is_answered || !last->needs_silence;
}

void Oracle::note_use(const Flight& flight) {
  if (is_tcp(flight.bus)) {
    return;
  }
  LineUse& use = books_[flight.bus].use;
  use.first_read = Instant::min();
  use.is_answered = flight.is_broadcast;
}

}  // namespace mbgate::soak
