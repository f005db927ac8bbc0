// SPDX-License-Identifier: Apache-2.0
#include "soak/turns.hpp"

#include <algorithm>
#include <set>

#include "soak/client.hpp"
#include "soak/oracle.hpp"

namespace mbgate::soak {

namespace {

constexpr std::ptrdiff_t kMostTurns = 5;  // of any weight that is drawn
constexpr unsigned kPassedOver = 2;       // once, and by who had the turn already

// What was granted by the weight that a reload has changed comes first.
std::optional<Instant> weight_holds_from(const std::vector<Instant>& reads, Instant touched) {
  const auto since = std::ranges::upper_bound(reads, touched);
  if (touched == Instant::min()) {
    return touched;
  }
  return reads.end() - since < kMostTurns ? std::nullopt : std::optional(since[kMostTurns - 1]);
}

// Whatever it is a part of, and whether it was answered or not. What reads may be a question before
// a write, or a read; stops are not counted.
void count_writes(const Flight& flight, const Book& book, Turns& turns) {
  if (book.is_unused || flight.begin <= book.touched + std::chrono::seconds(1)) {
    turns.writes = 0;
  }
  if (!flight.is_stop) {
    turns.writes = flight.is_write ? turns.writes + 1 : 0;
  }
}

}  // namespace

void TurnRules::check(const Flight& flight) const {
  if (oracle_.is_tcp(flight.bus)) {
    return;
  }
  Turns& turns = oracle_.books_[flight.bus].turns;
  const Asked* asked = only_one(flight);
  const bool is_read = asked != nullptr && asked->is_read();
  const bool has_older_weight = asked != nullptr && asked->accepted < oracle_.reloaded_;
  if (asked == nullptr || has_older_weight || !is_clear(flight)) {
    turns.reads.clear();
    turns.last.clear();
    turns.since_empty.clear();
    turns.reader.reset();
  } else {
    if (oracle_.reloaded_ > turns.read_at) {
      turns.since_empty.clear();
      turns.reader.reset();
    }
    judge(flight, *asked, turns);
    count(flight, *asked, turns);
    turns.last[asked->host] = flight.begin;
    if (is_read) {
      turns.reads[asked->host].push_back(flight.begin);
    }
  }
  turns.most_writes = is_read ? 0 : turns.most_writes + 1;
  count_writes(flight, oracle_.books_[flight.bus], turns);
  note_empty(flight, turns);
}

// Of whom nothing waits has all turns of its weight before it when something comes.
void TurnRules::note_empty(const Flight& flight, Turns& turns) const {
  std::set<unsigned> may_wait;
  for (const Lane& lane : oracle_.books_[flight.bus].lanes) {
    for (const Asked* asked : lane.open) {
      may_wait.insert(asked->host);
    }
  }
  for (const Manners& client : oracle_.plan_.clients) {
    if (!may_wait.contains(client.host)) {
      turns.since_empty[client.host] = 0;
    }
  }
}

// The request that alone it is for, for the first time, and which is no more than that.
const Asked* TurnRules::only_one(const Flight& flight) const {
  if (flight.is_stop || flight.is_broadcast || flight.is_part || flight.asked.size() != 1) {
    return nullptr;
  }
  const auto entry = oracle_.open_.find(flight.asked.front());
  return entry == oracle_.open_.end() || entry->second->flights > 1 ||
                 (entry->second->kind != Kind::read && entry->second->kind != Kind::write)
             ? nullptr
             : entry->second.get();
}

bool TurnRules::is_clear(const Flight& flight) const {
  const Book& book = oracle_.books_[flight.bus];
  const auto is_done = [&](const Asked* asked) {
    return !asked->maybe_on_wire || asked->id == flight.asked.front();
  };
  return book.use.is_answered && book.open && book.opened < flight.begin &&
         flight.begin > book.touched + std::chrono::seconds(1) && !oracle_.stopping_ &&
         book.has_only_usual() && std::ranges::all_of(book.lanes, [&](const Lane& lane) {
           return std::ranges::all_of(lane.open, is_done);
         });
}

std::vector<const Asked*> TurnRules::others_that_may_go(const Flight& flight,
                                                        Duration most_gap) const {
  std::vector<const Asked*> others;
  for (const Lane& lane : oracle_.books_[flight.bus].lanes) {
    for (const Asked* asked : lane.open) {
      if (asked->id != flight.asked.front() && may_go(*asked, lane, flight, most_gap)) {
        others.push_back(asked);
      }
    }
  }
  return others;
}

bool TurnRules::waits_for_its_turn(const Asked& asked, const Flight& flight) {
  return (asked.is_read() || asked.kind == Kind::write) && asked.pieces.size() == 1 &&
         asked.pieces.front().counted && !asked.dropped && !asked.doomed && !asked.ordered &&
         !asked.ahead && !asked.pieces.front().taken_back && asked.accepted < flight.begin &&
         flight.begin < asked.deadline - (asked.written - asked.earliest);
}

Duration TurnRules::gap_at(const Lane& lane) const {
  return oracle_.devices_[*lane.device].settings().timing.gap;
}

// It waits for nothing but its turn: the oldest of its client to a device that owes nothing, is
// there, and needs no gap that is longer.
bool TurnRules::may_go(const Asked& asked, const Lane& lane, const Flight& flight,
                       Duration most_gap) const {
  if (!waits_for_its_turn(asked, flight) || !lane.device || lane.held_until >= flight.begin ||
      oracle_.is_past_offline(flight.bus, lane) || gap_at(lane) > most_gap) {
    return false;
  }
  return std::ranges::none_of(lane.open, [&](const Asked* other) {
    return other->host == asked.host && other->sequence < asked.sequence;
  });
}

unsigned TurnRules::weight_of(unsigned host) const {
  const auto& weights = oracle_.plan_.settings.weights;
  const auto fitting = std::ranges::find_if(
      weights, [&](const auto& it) { return it.network.contains(address_of(host)); });
  return fitting == weights.end() ? 1 : fitting->weight;
}

void TurnRules::judge(const Flight& flight, const Asked& asked, const Turns& turns) const {
  const unsigned burst = oracle_.bus_settings(flight.bus).burst;
  const auto others = others_that_may_go(flight);
  if (asked.is_read()) {
    const auto write = std::ranges::find_if(others, &Asked::changes);
    if (write != others.end() && turns.most_writes < burst) {
      oracle_.violation("write_overtaken", oracle_.name(**write) + " by " + oracle_.name(asked));
    }
    // Where others write, they go between.
    const bool all_read = oracle_.plan_.theme == Theme::busy_line;
    judge_reads(flight, asked, turns, all_read ? others_that_may_go(flight, kLongestGap) : others);
    judge_weight(asked, turns, others);
    return;
  }
  const auto read = std::ranges::find_if(others, &Asked::is_read);
  if (read != others.end() && turns.writes >= burst) {
    oracle_.violation("read_starved", oracle_.name(**read) + " after " +
                                          std::to_string(turns.writes) + " writes by " +
                                          oracle_.name(asked));
  }
}

// While a read of one client waits for its turn, each other client has as many as its weight says,
// and some more where it waits for its device's gap too: then it is passed over once.
void TurnRules::judge_reads(const Flight& flight, const Asked& read, const Turns& turns,
                            const std::vector<const Asked*>& others) const {
  const auto mine = turns.reads.find(read.host);
  const auto from = mine == turns.reads.end()
                        ? std::nullopt
                        : weight_holds_from(mine->second, oracle_.books_[flight.bus].touched);
  if (!from) {
    return;
  }
  for (const Asked* other : others) {
    if (!other->is_read() || other->host == read.host) {
      continue;
    }
    const Lane& lane = oracle_.books_[flight.bus].lanes[other->pieces.front().address];
    const auto last = turns.last.find(other->host);
    const Instant since = std::max({other->accepted, lane.held_until, *from,
                                    last == turns.last.end() ? Instant::min() : last->second});
    const auto count = 1U + static_cast<unsigned>(std::ranges::count_if(
                                mine->second, [&](Instant at) { return at > since; }));
    const unsigned passed = gap_at(lane) > Duration{0} ? kPassedOver : 0;
    if (count > weight_of(read.host) + passed) {
      oracle_.violation("unfair", oracle_.name(*other) + " while host " +
                                      std::to_string(read.host) + " had " + std::to_string(count) +
                                      " turns");
      return;
    }
  }
}

// A client address that was served before another one, which could have gone then too, stays before
// it until it has had the turns of its weight, if it always has something that waits.
void TurnRules::judge_weight(const Asked& read, const Turns& turns,
                             const std::vector<const Asked*>& others) const {
  if (!turns.reader || *turns.reader == read.host ||
      std::ranges::find(turns.came_after, read.id) == turns.came_after.end()) {
    return;
  }
  const auto taken = turns.since_empty.find(*turns.reader);
  if (taken == turns.since_empty.end() || taken->second % weight_of(*turns.reader) == 0) {
    return;
  }
  const auto left = std::ranges::find_if(others, [&](const Asked* other) {
    return other->is_read() && other->host == *turns.reader && other->accepted < turns.read_at;
  });
  if (left != others.end()) {
    oracle_.violation("turn_cut_short", oracle_.name(**left) + " after " +
                                            std::to_string(taken->second) + " turns by " +
                                            oracle_.name(read));
  }
}

// How many turns an address has had since nothing of it waited is known as long as something did
// for certain, or nothing for certain.
void TurnRules::count(const Flight& flight, const Asked& asked, Turns& turns) const {
  const auto& lanes = oracle_.books_[flight.bus].lanes;
  bool may_wait = false;
  bool waits = false;
  for (const Lane& lane : lanes) {
    for (const Asked* other : lane.open) {
      if (other->host == asked.host && other->id != asked.id) {
        may_wait = true;
        waits = waits || waits_for_its_turn(*other, flight);
      }
    }
  }
  const auto known = turns.since_empty.find(asked.host);
  const auto last = turns.last.find(asked.host);
  const bool was_empty = known != turns.since_empty.end() && known->second == 0;
  const bool has_waited = known != turns.since_empty.end() && last != turns.last.end() &&
                          !asked.ordered && !asked.ahead && asked.accepted < last->second;
  if (!may_wait) {
    turns.since_empty[asked.host] = 0;
  } else if (waits && (was_empty || has_waited)) {
    ++known->second;
  } else {
    turns.since_empty.erase(asked.host);
  }
  note_reader(flight, asked, turns);
}

void TurnRules::note_reader(const Flight& flight, const Asked& asked, Turns& turns) const {
  turns.reader.reset();
  turns.came_after.clear();
  if (!asked.is_read()) {
    return;
  }
  turns.reader = asked.host;
  turns.read_at = flight.begin;
  for (const Asked* other : others_that_may_go(flight)) {
    if (other->is_read() && other->host != asked.host) {
      turns.came_after.push_back(other->id);
    }
  }
}

}  // namespace mbgate::soak
