// SPDX-License-Identifier: Apache-2.0
// When the gateway can first have taken a request, and what that means for others.
#include <algorithm>

#include "soak/oracle.hpp"

namespace mbgate::soak {

void Oracle::accept_backlog(Session& session) {
  const std::size_t pipeline = plan_.settings.listeners[session.listener].pipeline;
  while (!session.backlog.empty() && session.outstanding < pipeline) {
    Asked& asked = *open_.at(session.backlog.front());
    session.backlog.pop_front();
    ++session.outstanding;
    session.order.push_back(asked.id);
    asked.dropped = session.half_closed && asked.changes();
    asked.ordered = plan_.settings.listeners[session.listener].ordered;
    asked.ahead = session.ahead;
    if (!asked.is_accepted) {
      accept(asked);
    }
  }
}

void Oracle::accept(Asked& asked) {
  asked.is_accepted = true;
  asked.accepted = schedule_.now();
  asked.sequence = ++sequence_;
  if (asked.door == nullptr) {
    return;
  }
  if (asked.kind != Kind::stop) {
    asked.deadline =
        asked.written + (asked.is_read() ? asked.door->read_deadline : asked.door->write_deadline);
  }
  if (asked.refused) {
    return;
  }
  if (asked.kind == Kind::stop && !asked.dropped) {
    cancel_for_stop(asked);
  }
  for (Piece& piece : asked.pieces) {
    Book& book = books_[piece.bus];
    if (&piece == &asked.pieces.front() || piece.bus != asked.pieces.front().bus) {
      if (book.present >= bus_settings(piece.bus).queue) {
        book.last_full = schedule_.now();
      }
      ++book.present;
      // One part of a broadcast may be refused while others wait.
      const bool whole = asked.kind != Kind::broadcast || asked.pieces.size() == 1;
      if (asked.kind != Kind::stop && whole && !asked.dropped && !asked.ordered && !asked.ahead) {
        piece.counted = true;
        ++book.waiting;
      }
    }
    auto& lane = book.lanes[piece.address].open;
    if (lane.empty() || lane.back() != &asked) {
      lane.push_back(&asked);
    }
    if (asked.kind == Kind::stop && book.open && !asked.dropped) {
      asked.waits_from = schedule_.now();
      book.stops.push_back(&asked);
      book.open_stops.push_back(&asked);
    }
  }
}

// Writes to the same device that wait will never be sent.
void Oracle::cancel_for_stop(const Asked& stop) {
  const Piece& piece = stop.pieces.front();
  Lane& lane = books_[piece.bus].lanes[piece.address];
  lane.last_stop = books_[piece.bus].last_stop = schedule_.now();
  if (!devices_[*stop.door->device].settings().stop_cancels) {
    return;
  }
  for (Asked* asked : lane.open) {
    if (asked->kind == Kind::write && !asked->doomed) {
      asked->doomed = schedule_.now();
    }
  }
}

// What was on the wire was surely accepted, and so was what has waited.
void Oracle::note_write_event(const Asked& asked, std::optional<std::size_t> bus) {
  const bool waited = asked.kind != Kind::broadcast && asked.accepted < schedule_.now();
  if (!asked.changes() || asked.refused || asked.ordered || !(asked.surely_on_wire || waited)) {
    return;
  }
  for (const Piece& piece : asked.pieces) {
    if (asked.kind != Kind::broadcast) {
      books_[piece.bus].lanes[piece.address].last_write_event = schedule_.now();
    } else if (piece.bus == bus || (!bus && asked.pieces.size() == 1)) {
      // Where it was one of several, its part may have ended before the others.
      for (Lane& lane : books_[piece.bus].lanes) {
        lane.last_write_event = schedule_.now();
      }
    }
  }
}

bool Oracle::is_surely_open(const Asked& asked) const {
  if (!asked.ordered) {
    return true;
  }
  const auto entry = sessions_.find(asked.client);
  return entry != sessions_.end() && !entry->second.order.empty() &&
         entry->second.order.front() == asked.id;
}

void Oracle::leave_queue(Piece& piece) {
  if (piece.counted) {
    piece.counted = false;
    --books_[piece.bus].waiting;
  }
}

}  // namespace mbgate::soak
