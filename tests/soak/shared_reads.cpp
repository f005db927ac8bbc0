// SPDX-License-Identifier: Apache-2.0
#include "soak/shared_reads.hpp"

#include <algorithm>

#include "soak/oracle.hpp"

namespace mbgate::soak {
namespace {

// Without it a merged read would begin later or end earlier.
bool is_needed(const PduBytes& part, const Flight& flight, const SharedReads::Meant& meant) {
  const auto begin_of = [](const PduBytes& pdu) { return unsigned{spec::word_at(pdu, 1)}; };
  const auto end_of = [&](const PduBytes& pdu) { return begin_of(pdu) + spec::word_at(pdu, 3); };
  const auto is_only = [&](const auto& place) {
    return place(part) == place(flight.pdu) &&
           std::ranges::count_if(meant, [&](const auto& other) {
             return place(other.second->pdu) == place(flight.pdu);
           }) == 1;
  };
  return is_only(begin_of) || is_only(end_of);
}

}  // namespace

// Reads that are transmitted as one: never longer than the drive takes, never across a parameter
// group, never over registers that cannot be read. What one request asks for is its own matter.
void SharedReads::check_bounds(const Flight& flight) const {
  const auto& device = oracle_.books_[flight.bus].lanes[flight.address].device;
  const bool is_merged = std::ranges::none_of(flight.asked, [&](std::uint64_t id) {
    const auto entry = oracle_.open_.find(id);
    return entry == oracle_.open_.end() ||
           std::ranges::any_of(entry->second->pieces,
                               [&](const Piece& piece) { return piece.pdu == flight.pdu; });
  });
  const auto fields = is_merged ? spec::fields_of(flight.pdu) : std::nullopt;
  if (!device || !fields || !fields->reads || flight.asked.empty()) {
    return;
  }
  const drive::Profile& profile = oracle_.devices_[*device].settings().profile;
  const spec::Range& range = *fields->reads;
  const unsigned end = range.first + range.count;
  const auto meets = [&](const auto& other) {
    return other.table == range.table && other.first < end &&
           range.first < unsigned{other.first} + other.count;
  };
  const auto crosses = [&](const auto& group) {
    const unsigned group_end = unsigned{group.first} + group.count;
    return meets(group) && (range.first < group.first || end > group_end);
  };
  if (range.count > profile.limits.read_from(range.table)) {
    oracle_.violation("merged_too_long", oracle_.name(flight));
  }
  if (std::ranges::any_of(profile.write_only, meets) ||
      std::ranges::any_of(profile.groups, crosses)) {
    oracle_.violation("merged_too_far", oracle_.name(flight));
  }
}

// What was surely merged is not merged again when that failed as often as it may be tried. It is
// repeated as long as it was, also when who asked for its begin or its end has gone: who asks for
// them then joins it no more.
void SharedReads::count_tries(Flight& flight, const Meant& meant) const {
  if (oracle_.is_tcp(flight.bus)) {
    return;
  }
  const Flight* before = last_like(flight, meant);
  for (const auto& [asked, piece] : meant) {
    const bool was_there =
        before == nullptr || std::ranges::count(before->merged_for, asked->id) > 0;
    const bool is_merged = asked->is_read() && piece->pdu != flight.pdu && was_there;
    if (!is_merged || !is_needed(piece->pdu, flight, meant)) {
      continue;
    }
    flight.merged_for.push_back(asked->id);
    if (++asked->merged_tries > 1 + asked->retries) {
      oracle_.violation("merged_too_often", oracle_.name(*asked));
    }
  }
}

// The last one that it may repeat.
const Flight* SharedReads::last_like(const Flight& flight, const Meant& meant) const {
  const Flight* last = nullptr;
  for (const auto& [asked, piece] : meant) {
    for (const std::uint64_t number : asked->tries) {
      const Flight* other = oracle_.flight(number);
      if (other != nullptr && other->pdu == flight.pdu &&
          (last == nullptr || last->number < number)) {
        last = other;
      }
    }
  }
  return last;
}

// It was accepted, and nothing can have ended it.
bool SharedReads::surely_waits(const Asked& write, std::size_t bus) const {
  const Book& book = oracle_.books_[bus];
  const Instant now = oracle_.schedule_.now();
  const bool is_one = write.pieces.size() == 1 || write.kind != Kind::broadcast;
  return write.changes() && !write.is_stop() && write.is_accepted && write.accepted < now &&
         !write.maybe_on_wire && !write.dropped && !write.doomed && !write.ordered &&
         !write.ahead && !write.client_gone && write.earliest == write.written &&
         now < write.deadline && is_one && book.last_down < write.accepted &&
         oracle_.reloaded_ < write.accepted &&
         std::ranges::none_of(write.pieces, [](const Piece& piece) {
           return piece.sent > 0 || piece.doomed || piece.taken_back;
         });
}

void SharedReads::note_writes(Flight& flight, const Meant& meant) const {
  if (meant.size() < 2 || !meant.front().first->is_read()) {
    return;
  }
  flight.is_for_each = is_for_each(flight, meant);
  const auto& lanes = oracle_.books_[flight.bus].lanes;
  const auto note = [&](const Lane& lane) {
    for (const Asked* asked : lane.open) {
      if (surely_waits(*asked, flight.bus)) {
        flight.waiting_writes.push_back(asked->sequence);
      }
    }
  };
  note(lanes[flight.address]);
  if (!oracle_.is_tcp(flight.bus)) {
    note(lanes[0]);
    note(lanes[kAutonicsAddress]);
  }
}

// Where no write could keep them apart, all that are alike are transmitted once. Who does not share
// the first try shares no other one.
bool SharedReads::is_for_each(const Flight& flight, const Meant& meant) const {
  const Book& book = oracle_.books_[flight.bus];
  if (!oracle_.bus_settings(flight.bus).coalesce || oracle_.is_tcp(flight.bus) ||
      flight.begin <= std::max(book.touched, oracle_.reloaded_) + std::chrono::seconds(1)) {
    return false;
  }
  const std::uint64_t before = meant.front().first->last_flight;
  if (before != 0) {
    const Flight* last = oracle_.flight(before);
    return last != nullptr && last->is_for_each && last->begin >= book.opened &&
           std::ranges::all_of(meant,
                               [&](const auto& it) { return it.first->last_flight == before; });
  }
  const auto is_quiet = [&](const Lane& lane) {
    return std::ranges::none_of(lane.open, &Asked::changes);
  };
  return is_quiet(book.lanes[flight.address]) && is_quiet(book.lanes[0]) &&
         is_quiet(book.lanes[kAutonicsAddress]) && std::ranges::all_of(meant, [&](const auto& it) {
           return joins_for_certain(*it.first, flight, meant);
         });
}

// It waits, and is the first of its client address for the device, or behind others that join.
bool SharedReads::joins_for_certain(const Asked& asked, const Flight& flight,
                                    const Meant& meant) const {
  const auto joins = [&](const Asked* other) {
    return std::ranges::any_of(meant, [&](const auto& it) { return it.first == other; });
  };
  const Piece& piece = asked.pieces.front();
  return asked.is_read() && asked.flights == 0 && asked.pieces.size() == 1 && piece.counted &&
         piece.pdu == flight.pdu && !piece.taken_back && !asked.ordered && !asked.ahead &&
         !asked.client_gone && std::max(asked.accepted, asked.waited_until) < flight.begin &&
         flight.begin < asked.deadline - (asked.written - asked.earliest) &&
         std::ranges::all_of(
             oracle_.books_[flight.bus].lanes[flight.address].open,
             [&](const Asked* other) { return other->host != asked.host || joins(other); });
}

// It waits for its turn or its next try: nothing is in flight now.
bool SharedReads::surely_waits_before(const Asked& read, const Asked& broadcast,
                                      const Book& book) const {
  const Instant now = oracle_.schedule_.now();
  const Piece& piece = read.pieces.front();
  const bool is_before = read.client == broadcast.client ? read.sequence < broadcast.sequence
                                                         : read.accepted < broadcast.accepted;
  return read.is_read() && read.host == broadcast.host && is_before && !read.ordered &&
         !read.ahead && !read.client_gone && read.earliest == read.written &&
         read.accepted > std::max(book.opened, oracle_.reloaded_) && now < read.deadline &&
         !oracle_.is_past_offline(piece.bus, book.lanes[piece.address]);
}

// It is a write to every drive of the bus: what its client address asked for before goes first.
void SharedReads::check_overtaken(const Asked& broadcast, const Flight& flight) const {
  const Book& book = oracle_.books_[flight.bus];
  for (const Lane& lane : book.lanes) {
    for (const Asked* read : lane.open) {
      if (surely_waits_before(*read, broadcast, book)) {
        oracle_.violation("order", oracle_.name(broadcast) + " before " + oracle_.name(*read));
        return;
      }
    }
  }
}

// Two that one transmission has answered were accepted with a write between them that waited.
void SharedReads::judge_joined(const Asked& asked) const {
  Flight* flight = asked.tries.size() == 1 ? oracle_.flight(asked.tries.front()) : nullptr;
  if (flight == nullptr || !asked.is_read() || asked.pieces.size() > 1 || asked.ordered ||
      asked.ahead || asked.earliest != asked.written) {
    return;
  }
  for (const std::uint64_t other : flight->answered) {
    const auto [first, last] = std::minmax(other, asked.sequence);
    const bool crosses = std::ranges::any_of(
        flight->waiting_writes,
        [first = first, last = last](auto write) { return first < write && write < last; });
    if (crosses) {
      oracle_.violation("joined_across_write", oracle_.name(asked));
      return;
    }
  }
  flight->answered.push_back(asked.sequence);
}

}  // namespace mbgate::soak
