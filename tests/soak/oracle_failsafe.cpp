// SPDX-License-Identifier: Apache-2.0
// Stops that nobody is told of: failsafe writes, and those whose client has gone.
#include <algorithm>
#include <iterator>

#include "soak/oracle.hpp"
#include "soak/withdrawals.hpp"

namespace mbgate::soak {
namespace {

constexpr Duration kFailsafeLife = std::chrono::seconds(10);  // it may be repeated
constexpr Duration kFailsafeWait = std::chrono::seconds(4);   // on a slow line, and for each of the
constexpr Duration kBehindStop = std::chrono::seconds(1);     // stops that it is behind

}  // namespace

// What is due goes as a stop of a client that has gone.
void Oracle::begin_failsafe() {
  if (stopping_) {
    return;
  }
  for (Asked& due : failsafe_.take_due(schedule_.now())) {
    due.id = ++ids_;
    ++failsafes_;
    if (!books_[due.pieces.front().bus].open) {
      report_.fault("failsafe_line_away");
    }
    const auto entry = open_.emplace(due.id, std::make_unique<Asked>(std::move(due))).first;
    entry->second->let_writes_go = lets_writes_go(*entry->second);
    accept(*entry->second);
  }
}

// Of those that are repeated, and were due more than once, nobody can tell which is sent; nor of
// those that let writes go between them, and so are not sent as one. A reload that lets none go any
// more takes these writes back, but makes no one of two that wait already.
unsigned Oracle::failsafes_like(const Asked& asked, const Piece& piece) const {
  const bool are_apart = asked.is_repeated || lets_writes_go(asked);
  unsigned like = 0;
  for (const Asked* other : books_[piece.bus].lanes[piece.address].open) {
    if (other->failsafe && other->pdu == asked.pdu) {
      like += like == 0 || are_apart || other->let_writes_go ? 1U : 0U;
    }
  }
  return like;
}

// A client that may write asks again: what could not be sent yet must not be sent any more. What
// the bus has already goes on, unless its line is lost before.
void Oracle::drop_failsafe(std::size_t device) {
  const drive::Device& at = plan_.settings.devices[device];
  const auto bus = static_cast<std::size_t>(at.bus);
  for (Asked* asked : books_[bus].lanes[at.address].open) {
    asked->is_unwanted = asked->failsafe && asked->flights == 0 && !asked->dropped;
  }
  if (!books_[bus].open) {
    drop_unwanted(bus);
  }
}

// Where the bus itself may have it already, nobody can tell.
void Oracle::drop_unwanted(std::size_t bus) {
  const Book& book = books_[bus];
  std::vector<Asked*> unwanted;
  for (const Lane& lane : book.lanes) {
    std::ranges::copy_if(lane.open, std::back_inserter(unwanted), [](const Asked* asked) {
      return asked->is_unwanted && asked->flights == 0 && !asked->dropped;
    });
  }
  for (Asked* asked : unwanted) {
    report_.fault("failsafe_client_back");
    if (book.starting || is_tcp(bus)) {
      asked->dropped = true;
    } else {
      close(*asked, "failsafe_stale");
    }
  }
}

// What could not be sent yet goes now, and takes back what has come meanwhile.
void Oracle::failsafe_line_back(Book& book) {
  for (const Lane& lane : book.lanes) {
    for (Asked* asked : lane.open) {
      const bool is_due = asked->failsafe && asked->flights == 0 && !asked->dropped;
      if (is_due && std::ranges::find(book.stops, asked) == book.stops.end()) {
        asked->waits_from = asked->accepted = schedule_.now();
        Withdrawals(*this).take_back_for(*asked);
        book.stops.push_back(asked);
        if (std::ranges::find(book.open_stops, asked) == book.open_stops.end()) {
          book.open_stops.push_back(asked);
        }
      }
    }
  }
}

Duration Oracle::behind_others(const Asked& stop) const {
  return static_cast<int>(books_[stop.pieces.front().bus].open_stops.size()) * kBehindStop;
}

// Once it is due, only a line that is away, or has just come back, excuses that it is not sent.
bool Oracle::waits_for_line(const Asked& asked) const {
  const Book& book = books_[asked.pieces.front().bus];
  const bool is_late = schedule_.now() > std::max(book.last_down, asked.accepted) + kFailsafeWait +
                                             behind_others(asked);
  return asked.failsafe && !asked.dropped && (!book.open || (asked.flights == 0 && !is_late));
}

void Oracle::check_failsafe(const Asked& asked) {
  if (asked.failsafe && asked.flights == 0 && !asked.dropped && !waits_for_line(asked)) {
    violation("failsafe_missing", name(asked));
  }
}

// Stops are sent though their client has gone, and nobody is told of their end.
void Oracle::forget_gone_stops() {
  std::vector<Asked*> over;
  for (const auto& [id, asked] : open_) {
    const bool done = asked->failsafe && asked->flights > 0;
    const Duration life = done ? kFailsafeLife + behind_others(*asked) : kStopLife;
    if (asked->client_gone && !waits_for_line(*asked) && schedule_.now() > asked->accepted + life) {
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
