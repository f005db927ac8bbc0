// SPDX-License-Identifier: Apache-2.0
// A good answer ends a request, and a read is not given up before it was tried as often as its
// device's settings say.
#include <algorithm>

#include "soak/oracle.hpp"

namespace mbgate::soak {

// It is asked once more, or was told that there is no answer. A merged read that was for it alone,
// because the others have gone, may be refused; then its part is sent.
void Oracle::check_answered(const Asked& asked) {
  const Flight* refused = asked.last_alone != 0 ? flight(asked.last_alone) : nullptr;
  if (stopping_ || (refused != nullptr && asked.is_stop() && refused->refused)) {
    return;
  }
  const Flight* last = asked.last_alone != 0 ? flight(asked.last_alone) : nullptr;
  if (last != nullptr && last->is_answered && !last->is_cut_off && asked.pieces.size() == 1 &&
      last->pdu == asked.pieces.front().pdu && books_[last->bus].last_down < last->begin) {
    violation("answer_lost",
              name(asked) + ", answered " +
                  std::to_string((schedule_.now() - last->begin) / std::chrono::microseconds(1)) +
                  " us after it was transmitted");
  }
}

// A drive that has refused a stop has time to think about it.
void Oracle::check_pause(const Asked& asked, const Flight& flight) {
  const Flight* last = asked.last_alone != 0 ? this->flight(asked.last_alone) : nullptr;
  if (!asked.is_stop() || last == nullptr || !last->refused_at || !last->is_answered || stopping_ ||
      reloaded_ >= last->begin) {
    return;
  }
  // If the wait for its answer went on, the exception was taken for that to an earlier one.
  if (flight.begin <
      std::min<Instant>(last->due, *last->refused_at + bus_settings(flight.bus).stop_wait)) {
    violation(
        "stop_repeated_early",
        name(flight) + ", refused " +
            std::to_string((flight.begin - *last->refused_at) / std::chrono::microseconds(1)) +
            " us ago, stop_wait " +
            std::to_string(bus_settings(flight.bus).stop_wait / std::chrono::microseconds(1)));
  }
}

// Nothing came to any of its tries: what is heard and fits nothing is a reason to ask once more, or
// not.
bool Oracle::was_silent(const Asked& asked) const {
  return std::ranges::all_of(asked.tries, [&](std::uint64_t number) {
    const Flight* it = flight(number);
    return it != nullptr && it->came == 0;
  });
}

// It was told that there is no answer. Who shares a read has been there since its first try; where
// others asked for the same apart, some tries may have been theirs, and it had fewer.
void Oracle::judge_tries(const Asked& asked) {
  if (stopping_) {
    return;
  }
  if (!asked.is_read() || !asked.door->device || asked.pieces.size() != 1 || asked.ordered ||
      asked.flights == 0 || may_be_offline(asked)) {
    return;
  }
  const Piece& piece = asked.pieces.front();
  const Book& book = books_[piece.bus];
  const unsigned retries = devices_[*asked.door->device].settings().timing.retries;
  const bool may_end = schedule_.now() >= asked.deadline - (asked.written - asked.earliest) ||
                       book.last_down >= asked.accepted || reloaded_ >= asked.accepted ||
                       piece.taken_back || is_tcp(piece.bus) || bus_settings(piece.bus).merge;
  if (!may_end && asked.flights < 1 + retries && was_silent(asked)) {
    violation("given_up", name(asked) + " after " + std::to_string(asked.flights) + " tries");
  }
}

// It was answered without being transmitted: not by what was read before its device left something
// unanswered.
void Oracle::judge_cached(const Asked& asked) {
  if (asked.kind != Kind::read || asked.ordered || asked.flights > 0 || asked.pieces.empty()) {
    return;
  }
  const Piece& piece = asked.pieces.front();
  const Book& book = books_[piece.bus];
  const Flight* last = flight(book.last_flight);
  const bool is_over = last != nullptr && last->address == piece.address && last->expects_answer &&
                       !last->is_broadcast && !is_tcp(piece.bus) && book.came == 0 &&
                       reloaded_ < last->begin && book.opened <= last->begin &&
                       schedule_.now() > last->due + lateness();
  if (book.lanes[piece.address].silent > 0 || is_over) {
    violation("cached_too_long", name(asked));
  }
}

// By itself, after a merged read that failed, and once more because its connection was closed.
void Oracle::check_tries(const Asked& asked) const {
  if (!asked.is_read() || asked.pieces.size() != 1) {
    return;
  }
  const std::size_t bus = asked.pieces.front().bus;
  const bool was_merged = bus_settings(bus).merge || books_[bus].last_merge >= asked.accepted;
  const unsigned tries = (1 + asked.retries) * (was_merged ? 2 : 1) + (is_tcp(bus) ? 1 : 0) +
                         (was_silent(asked) ? 0 : 1);
  if (asked.flights_alone > tries) {
    violation("read_too_often", name(asked) + ", " + std::to_string(tries) + " tries");
  }
}

}  // namespace mbgate::soak
