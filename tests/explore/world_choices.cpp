// SPDX-License-Identifier: Apache-2.0
// What may happen next, and to which instants time goes on.
#include <algorithm>

#include "explore/world.hpp"

namespace mbgate::explore {
namespace {

// A device takes so long to answer, at the least.
constexpr Duration kAnswering = 1ms;
constexpr Duration kAnInstant{1};
// A driver is not late by more, but for a process that is stopped, which is no other case.
constexpr Duration kLate = 20ms;
constexpr Duration kLatest = 500ms;

}  // namespace

bool World::is_due() const {
  const auto wake = harness_.next_wake();
  return wake && wake->at <= now();
}

const Flight* World::half_heard() const {
  const auto found = std::ranges::find_if(oracle_.flights(), &Flight::rest_comes);
  return found == oracle_.flights().end() ? nullptr : &*found;
}

// From then on its answer may come. A slow device begins with a request when it has answered the
// one before. The second of two answers comes at any time.
Instant World::opens(const Flight& flight) const {
  if (flight.first_at) {
    return *flight.first_at + kAnswering;
  }
  return is_slow(flight) && !flight.late ? flight.begins + plant_.device().timing.response_timeout
                                         : flight.left + kAnswering;
}

// Then it comes at the latest; if it is not late, anything else is a fault.
Instant World::closes(const Flight& flight) const {
  const drive::DeviceTiming& timing = plant_.device().timing;
  if (flight.first_at) {
    return *flight.first_at + timing.response_timeout;
  }
  if (flight.late) {
    return oracle_.end_of(flight);
  }
  return is_slow(flight) ? opens(flight) + world::quarantine_of(timing) : flight.due;
}

bool World::may_come(const Flight& flight) const {
  return flight.outstanding && now() >= opens(flight) && cost_of(flight) <= left_.faults;
}

// Its device would have left others unanswered.
unsigned World::cost_of(const Flight& flight) const {
  if (flight.first_at) {
    return 0;
  }
  return static_cast<unsigned>(std::ranges::count_if(oracle_.flights(), [&](const Flight& other) {
    return other.outstanding && !other.late && other.device == flight.device &&
           other.serial < flight.serial;
  }));
}

// It was to come until then at the latest, and has not.
bool World::is_missed(const Flight& flight, Instant until) const {
  return flight.rest_comes ? until >= oracle_.rest_end_of(flight)
                           : flight.outstanding && !flight.late && until >= closes(flight);
}

unsigned World::missed(Instant until) const {
  return static_cast<unsigned>(std::ranges::count_if(
      oracle_.flights(), [&](const Flight& it) { return is_missed(it, until); }));
}

// A deadline judges what has come by then; time that goes on passes all instants before the next.
bool World::may_pass() const {
  if (!asleep_since_ && is_due()) {
    return missed(now()) <= left_.faults;
  }
  const auto next = next_instant();
  return next && missed(*next - kAnInstant) <= left_.faults;
}

std::optional<Instant> World::next_instant() const {
  std::vector<Instant> edges;
  std::vector<Instant> instants;
  if (const auto wake = harness_.next_wake()) {
    edges.push_back(wake->at);
  }
  for (const Flight& flight : oracle_.flights()) {
    if (flight.outstanding) {
      // Where its own answer cannot come yet, that to an earlier request may.
      instants.push_back(flight.left + kAnswering);
      instants.push_back(opens(flight));
      edges.push_back(closes(flight));
    }
    if (flight.rest_comes) {
      edges.push_back(*flight.half_at + oracle_.silence());
      edges.push_back(oracle_.rest_end_of(flight));
    }
  }
  oracle_.add_edges(edges, left_.requests > 0);
  if (asleep_since_) {
    instants.push_back(*asleep_since_ + kLate);
    instants.push_back(*asleep_since_ + kLatest);
  }
  for (const Instant edge : edges) {
    if (edge + kAnInstant <= now()) {
      continue;
    }
    instants.push_back(edge);
    if (left_.instants > 1) {
      instants.push_back(edge - kAnInstant);
    }
    if (left_.instants > 2) {
      instants.push_back(edge + kAnInstant);
    }
  }
  std::erase_if(instants, [&](Instant it) { return it <= now(); });
  if (instants.empty()) {
    return std::nullopt;
  }
  const Instant next = std::ranges::min(instants);
  return asleep_since_ && next > *asleep_since_ + kLatest ? std::nullopt : std::optional(next);
}

// Devices are alike, and so are clients and the two reads: which is first does not matter.
void World::add_asks(std::vector<Choice>& choices) const {
  if (left_.requests == 0) {
    return;
  }
  const std::uint8_t clients = std::min<std::uint8_t>(clients_ + 1U, kClients);
  const std::uint8_t devices = std::min<std::uint8_t>(devices_ + 1U, kDevices);
  for (std::uint8_t client = 0; client < clients; ++client) {
    for (std::uint8_t device = 0; device < devices; ++device) {
      for (std::uint8_t word = 0; word < kWords; ++word) {
        if (has_read_ || static_cast<Word>(word) != Word::read_b) {
          choices.push_back({Act::ask, 0, {client, device, static_cast<Word>(word)}});
        }
      }
    }
  }
}

void World::add_answers(std::vector<Choice>& choices) const {
  if (const Flight* half = half_heard()) {
    choices.push_back({Act::rest, half->serial});
    return;  // nobody else can speak now
  }
  for (const Flight& flight : oracle_.flights()) {
    if (!may_come(flight)) {
      continue;
    }
    choices.push_back({Act::answer, flight.serial});
    // While something runs, nothing is transmitted, and the order makes no difference.
    if (left_.requests > 0 && !asleep_since_ && !oracle_.is_running()) {
      choices.push_back({Act::leave, flight.serial});
    }
    if (cost_of(flight) < left_.faults) {
      add_faults(choices, flight);
    }
  }
  // A device becomes slow when it is asked.
  const Flight* last = oracle_.flights().empty() ? nullptr : &oracle_.flights().back();
  if (left_.drives && left_.faults > 0 && last != nullptr && now() < last->left &&
      last->outstanding && !is_slow(*last)) {
    choices.push_back({Act::slow, last->device});
  }
}

void World::add_faults(std::vector<Choice>& choices, const Flight& flight) const {
  if (left_.forms) {
    choices.push_back({Act::damaged, flight.serial});
    choices.push_back({Act::twice, flight.serial});
    if (!asleep_since_) {
      choices.push_back({Act::half, flight.serial});
    }
  }
  if (left_.drives && !flight.late && !is_slow(flight)) {
    choices.push_back({Act::first, flight.serial});
  }
}

// The driver takes what is there, in any order.
void World::add_bunch(std::vector<Choice>& choices) {
  if (is_left_) {
    add_asks(choices);
    return;
  }
  if (!kernel_.empty()) {
    choices.push_back({Act::read});
    add_asks(choices);
  }
  for (std::uint8_t client = 0; client < kClients; ++client) {
    if (!sockets_[client].empty()) {
      choices.push_back({Act::take, client});
    }
  }
  if (is_due() && may_pass()) {
    choices.push_back({Act::pass});
  }
}

std::vector<Choice> World::choices() {
  std::vector<Choice> choices;
  if (!violation().empty()) {
    return choices;
  }
  const bool has_bunch = !kernel_.empty() || std::ranges::any_of(sockets_, [](const Octets& it) {
    return !it.empty();
  });
  if (has_bunch && !asleep_since_) {
    add_bunch(choices);
    return choices;
  }
  // What uses up nothing comes first: what is found there need not be gone through with less slack.
  add_answers(choices);
  add_asks(choices);
  if (may_pass()) {
    choices.push_back({Act::pass});
  }
  if (asleep_since_ && now() > *asleep_since_) {
    choices.push_back({Act::wake});
  } else if (!asleep_since_ && is_due() && left_.delays > 0) {
    choices.push_back({Act::sleep});
  }
  if (choices.empty() || (left_.requests > 0 && !is_due() && !next_instant())) {
    oracle_.note_end();
  }
  return choices;
}

std::string to_text(const Choice& choice) {
  const std::string which = " " + std::to_string(choice.which);
  switch (choice.act) {
    case Act::pass: return "pass";
    case Act::ask: return "ask: " + name_of(choice.ask);
    case Act::answer: return "answer" + which;
    case Act::damaged: return "answer" + which + ", damaged";
    case Act::twice: return "answer" + which + ", twice";
    case Act::first: return "answer" + which + ", the first of two";
    case Act::slow: return "device " + std::to_string(choice.which + 1) + " becomes slow";
    case Act::half: return "first half of answer" + which;
    case Act::rest: return "rest of answer" + which;
    case Act::leave: return "answer" + which + ", and clients first";
    case Act::sleep: return "the driver sleeps";
    case Act::wake: return "the driver wakes";
    case Act::read: return "the line is read";
    case Act::take: return "client " + std::to_string(choice.which + 1) + " is read";
  }
  return "";
}

}  // namespace mbgate::explore
