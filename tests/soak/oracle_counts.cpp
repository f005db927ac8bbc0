// SPDX-License-Identifier: Apache-2.0
// What the gateway's own counters must show, as far as the wire says it for certain.
#include "soak/oracle.hpp"

namespace mbgate::soak {

void Oracle::note_counts(const Flight& flight) {
  Book& book = books_[flight.bus];
  Lane& lane = book.lanes[flight.address];
  for (BusCount* count : {&book.count, &lane.count}) {
    ++count->transmissions;
    count->broadcasts += flight.is_broadcast ? 1U : 0U;
    count->stops += flight.is_stop ? 1U : 0U;
    count->asking += flight.expects_answer ? 1U : 0U;
  }
  ++book.since_echo;
  lane.unanswered += flight.expects_answer ? 1U : 0U;
  if (is_tcp(flight.bus) && flight.expects_answer) {
    lane.unheard.push_back(flight.number);
  }
}

// What came may have been taken for an answer that nobody gives, if only for a damaged one.
void Oracle::note_excused(const Flight& flight) {
  Book& book = books_[flight.bus];
  const bool is_counted = flight.expects_answer || flight.is_broadcast;
  for (BusCount* count : {&book.count, &book.lanes[flight.address].count}) {
    count->excused += is_counted ? 0U : 1U;
  }
}

// Whether what was sent last still waited for its answer is not known.
void Oracle::note_interrupted(Book& book) {
  book.count.losses += book.open || (book.rests && !book.is_restarted) ? 1U : 0U;
  if (book.open) {
    note_cut(book);
  }
}

void Oracle::note_cut(Book& book) {
  const auto note = [&](std::uint64_t number) {
    Flight* cut = flight(number);
    if (cut != nullptr) {
      cut->is_cut_off = true;
    }
    if (cut != nullptr && is_tcp(cut->bus) && schedule_.now() < deadline_of(*cut)) {
      std::erase(book.lanes[cut->address].unheard, number);  // says nothing of its device
    }
  };
  if (book.unheard.empty()) {
    note(book.last_flight);
  }
  for (const std::uint64_t number : book.unheard) {
    note(number);
  }
}

const BusCount& Oracle::count(std::size_t bus, std::uint8_t address) const {
  return books_[bus].lanes[address].count;
}

}  // namespace mbgate::soak
