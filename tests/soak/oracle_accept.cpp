// SPDX-License-Identifier: Apache-2.0
// When the gateway can first have taken a request, and what that means for others.
#include <algorithm>
#include <utility>

#include "bus/queue/stop_lane.hpp"
#include "gateway/limits.hpp"
#include "soak/oracle.hpp"
#include "soak/withdrawals.hpp"

namespace mbgate::soak {

void Oracle::delivered(ClientId client, std::uint64_t id) {
  Session& session = sessions_.at(client);
  session.backlog.push_back(id);
  Withdrawals(*this).let_pass(session, *open_.at(id));
  accept_backlog(session);
}

void Oracle::answer_sent(ClientId client) {
  const auto entry = sessions_.find(client);
  if (entry != sessions_.end()) {
    --entry->second.outstanding;
    accept_backlog(entry->second);
  }
}

void Oracle::accept_backlog(Session& session) {
  const std::size_t pipeline = plan_.settings.listeners[session.listener].pipeline;
  const auto takes_perhaps_no_place = [this](std::uint64_t id) {
    const Asked& stop = *open_.at(id);
    return stop.is_accepted && (stop.perhaps_older || stop.perhaps_later);
  };
  while (session.outstanding < pipeline || stopping_) {
    std::erase_if(session.taken, [&](std::uint64_t id) {
      return session.backlog.empty() || id <= session.backlog.front();
    });
    if (session.backlog.empty()) {
      return;
    }
    Asked& asked = *open_.at(session.backlog.front());
    session.backlog.pop_front();
    ++session.outstanding;
    session.order.push_back(asked.id);
    asked.dropped = session.half_closed && asked.changes() && !asked.is_stop();
    asked.ordered = session.ordered;
    asked.ahead = schedule_.now() < session.ahead_until ||
                  std::ranges::any_of(session.backlog, takes_perhaps_no_place);
    if (!asked.is_accepted) {
      accept(asked);
    }
  }
  look_ahead(session);
}

// Stops are taken out of what waits behind a full pipeline, so many at a time, unless they let a
// write go first that waits there too; on an ordered listener the answer keeps its place. Whether
// such a write is older than what its unit has come to mean, and goes before nothing, is not always
// known; and a stop that may be older is perhaps none any more, and takes no place: a broadcast, or
// what was not taken as it came and has lost its own time since. And where the gateway has perhaps
// not taken yet what is accepted here, it still has more of these stops than are known here: one
// that had to wait for room, or has got one of the last places, may have to wait longer, and takes
// no place either.
void Oracle::look_ahead(Session& session) {
  const std::deque<std::uint64_t> backlog = session.backlog;
  const bool is_unsure = std::ranges::any_of(session.order, [this](std::uint64_t id) {
    const Asked& asked = *open_.at(id);
    return asked.ahead && !asked.surely_on_wire;
  });
  const auto is_perhaps_held = [this](std::uint64_t id) {
    const auto stop = open_.find(id);
    return stop != open_.end() && stop->second->perhaps_held;
  };
  for (const std::uint64_t id : backlog) {
    const auto perhaps_held = std::ranges::count_if(session.taken, is_perhaps_held);
    if (std::ssize(session.taken) - perhaps_held >= std::ptrdiff_t{gateway::kStopReserve}) {
      return;
    }
    Asked& asked = *open_.at(id);
    if (asked.is_accepted || !asked.is_stop()) {
      continue;
    }
    const auto writes = Withdrawals(*this).held_by(backlog, asked);
    if (!std::ranges::all_of(writes, [this](const Asked* it) { return is_outdated(*it); })) {
      continue;
    }
    session.taken.push_back(id);
    asked.perhaps_held = !writes.empty();
    asked.ordered = session.ordered;
    const bool has_waited = id != backlog.back();
    const bool is_nearly_full = session.taken.size() > gateway::kStopReserve / 2;
    asked.perhaps_later = asked.perhaps_held || (is_unsure && (has_waited || is_nearly_full));
    accept(asked);
    asked.perhaps_older = asked.perhaps_older || (has_waited && is_outdated(asked));
    if (!asked.ordered) {
      client_rates_.went_ahead(asked);
    }
    if (!asked.ordered && !asked.perhaps_older && !asked.perhaps_later) {
      std::erase(session.backlog, id);
      ++session.outstanding;
      session.order.push_back(id);
    }
  }
}

void Oracle::accept(Asked& asked) {
  asked.is_accepted = true;
  asked.accepted = schedule_.now();
  asked.sequence = ++sequence_;
  client_rates_.accepted(asked, schedule_.now());
  asked.perhaps_older = Withdrawals(*this).is_older_broadcast(asked);
  rates_.accepted(asked, schedule_.now());
  if (asked.door == nullptr) {
    return;
  }
  note_allowed(asked);
  asked.word_order = order_of(*asked.door);
  if (!asked.is_stop()) {
    asked.deadline =
        asked.written + (asked.is_read() ? asked.door->read_deadline : asked.door->write_deadline);
  }
  if (asked.refused) {
    return;
  }
  writers_.attempted(asked, schedule_.now());
  note_failsafe_asked(asked);
  if (asked.is_stop()) {
    Withdrawals(*this).take_back_for(asked);
  }
  for (Piece& piece : asked.pieces) {
    Book& book = books_[piece.bus];
    const bool is_one_too_many = asked.is_stop() && book.open_stops.size() >= bus::kRoomForStops;
    if (is_first_on_its_bus(asked, piece)) {
      asked.found_no_room = asked.found_no_room || is_one_too_many;
      if (!asked.is_stop()) {
        book.note_size(bus_settings(piece.bus).queue, schedule_.now());
        ++book.present;
      }
      // One part of a broadcast may be refused while others wait.
      const bool whole = asked.kind != Kind::broadcast || asked.pieces.size() == 1;
      if (!asked.is_stop() && whole && !asked.dropped && !asked.ordered && !asked.ahead) {
        piece.counted = true;
        ++book.waiting;
      }
    }
    auto& lane = book.lanes[piece.address].open;
    if (lane.empty() || lane.back() != &asked) {
      lane.push_back(&asked);
    }
    if (asked.is_stop() && book.starting) {
      book.early_stops.push_back(&asked);
      book.open_stops.push_back(&asked);
    }
    if (asked.is_stop() && book.open) {
      asked.waits_from = schedule_.now();
      if (!is_one_too_many) {
        book.stops.push_back(&asked);
      }
      book.open_stops.push_back(&asked);
    }
  }
}

// In either form; each once.
std::vector<Asked*> Oracle::broadcasts_on(std::size_t bus) {
  std::vector<Asked*> found = books_[bus].lanes[0].open;
  for (Asked* asked : books_[bus].lanes[kAutonicsAddress].open) {
    if (std::ranges::find(found, asked) == found.end()) {
      found.push_back(asked);
    }
  }
  return found;
}

// What was on the wire was surely accepted, and so was what has waited.
void Oracle::note_write_event(const Asked& asked, std::optional<std::size_t> bus) {
  const bool waited =
      asked.kind != Kind::broadcast && !asked.ahead && asked.accepted < schedule_.now();
  if (!asked.changes() || asked.refused || asked.ordered || !(asked.surely_on_wire || waited)) {
    return;
  }
  const auto note = [&](Lane& lane) {
    if (lane.last_write_event != schedule_.now()) {
      lane.earlier_write_event = std::exchange(lane.last_write_event, schedule_.now());
    }
  };
  for (const Piece& piece : asked.pieces) {
    if (asked.kind != Kind::broadcast) {
      note(books_[piece.bus].lanes[piece.address]);
    } else if (piece.bus == bus || (!bus && asked.pieces.size() == 1)) {
      // Where it was one of several, its part may have ended before the others.
      for (Lane& lane : books_[piece.bus].lanes) {
        note(lane);
      }
    }
  }
}

bool Oracle::is_open(ClientId client, std::uint16_t transaction) const {
  const auto entry = sessions_.find(client);
  return entry != sessions_.end() && entry->second.by_transaction.contains(transaction);
}

std::size_t Oracle::open_of(ClientId client) const {
  const auto entry = sessions_.find(client);
  return entry == sessions_.end() ? 0 : entry->second.by_transaction.size();
}

bool Oracle::is_idle(ClientId client) const {
  const auto entry = sessions_.find(client);
  return entry != sessions_.end() && entry->second.by_transaction.empty() &&
         entry->second.outstanding == 0 && schedule_.now() >= entry->second.ahead_until;
}

bool Oracle::has_outstanding(ClientId client) const {
  const auto entry = sessions_.find(client);
  return entry != sessions_.end() &&
         std::ranges::any_of(entry->second.order,
                             [&](std::uint64_t id) { return !open_.at(id)->refused; });
}

bool Oracle::is_surely_open(const Asked& asked) const {
  if (asked.perhaps_older || asked.perhaps_later) {
    return false;  // it may be refused, once its turn comes, or only taken then
  }
  if (!asked.ordered) {
    return true;
  }
  const auto entry = sessions_.find(asked.client);
  // Behind a broadcast that gets no reply its answer may be held back too.
  return entry != sessions_.end() && !entry->second.order.empty() && entry->second.silent.empty() &&
         entry->second.order.front() == asked.id;
}

void Oracle::leave_queue(Piece& piece) {
  if (piece.counted) {
    piece.counted = false;
    --books_[piece.bus].waiting;
  }
}

}  // namespace mbgate::soak
