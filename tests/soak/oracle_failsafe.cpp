// SPDX-License-Identifier: Apache-2.0
// Stops that nobody is told of: failsafe writes, and those whose client has gone.
#include <algorithm>

#include "soak/oracle.hpp"

namespace mbgate::soak {
namespace {

constexpr Duration kFailsafeLife = std::chrono::seconds(10);  // it may be repeated

}  // namespace

// What is due goes as a stop of a client that has gone.
void Oracle::begin_failsafe() {
  for (Asked& due : failsafe_.take_due(schedule_.now())) {
    due.id = ++ids_;
    ++failsafes_;
    const auto entry = open_.emplace(due.id, std::make_unique<Asked>(std::move(due))).first;
    accept(*entry->second);
  }
}

// Of those that are repeated, and were due more than once, nobody can tell which is sent.
unsigned Oracle::failsafes_like(const Asked& asked, const Piece& piece) const {
  if (piece.pdu[2] != (kStopRegister & 0xFFU)) {
    return 1;
  }
  return static_cast<unsigned>(std::ranges::count_if(
      books_[piece.bus].lanes[piece.address].open,
      [&](const Asked* other) { return other->failsafe && other->pdu == asked.pdu; }));
}

// Once it is due, only a line that is away excuses that it is not sent.
void Oracle::check_failsafe(const Asked& asked) {
  const Book& book = books_[asked.pieces.front().bus];
  if (asked.failsafe && asked.flights == 0 && book.open && book.last_down < asked.accepted) {
    violation("failsafe_missing", name(asked));
  }
}

// Stops are sent though their client has gone, and nobody is told of their end.
void Oracle::forget_gone_stops() {
  std::vector<Asked*> over;
  for (const auto& [id, asked] : open_) {
    const bool done = asked->failsafe && asked->flights > 0;
    if (asked->client_gone &&
        schedule_.now() > asked->accepted + (done ? kFailsafeLife : kStopLife)) {
      over.push_back(asked.get());
    }
  }
  std::ranges::sort(over, {}, &Asked::id);
  for (Asked* asked : over) {
    check_failsafe(*asked);
    close(*asked, "stop_too_late");
  }
}

}  // namespace mbgate::soak
