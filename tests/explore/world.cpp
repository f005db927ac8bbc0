// SPDX-License-Identifier: Apache-2.0
#include "explore/world.hpp"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "explore/state_reader.hpp"

namespace mbgate::explore {
namespace {

constexpr gateway::BusId kLine{0};
// The line was opened so long ago that nothing of that counts any more.
constexpr Duration kQuiet = 30s;

gateway::ClientId client_id(std::uint8_t client) { return gateway::ClientId{client + 1U}; }

}  // namespace

World::World(const Plant& plant, const Bounds& bounds, bool is_reported)
    : plant_(plant),
      bounds_(bounds),
      left_(bounds),
      is_told_(is_reported),
      harness_(plant.settings, Instant{} + 1h),
      begun_(now() + kQuiet),
      oracle_(plant),
      seen_(now()) {
  settle();
  harness_.go_on(begun_);
  harness_.handle(gateway::DeadlineReached{});
  for (std::uint8_t client = 0; client < kClients; ++client) {
    const std::string address = "192.0.2." + std::to_string(client + 1);
    harness_.handle(gateway::ClientConnected{
        client_id(client), {routing::ListenerId{0}, *routing::ClientAddress::parse(address)}});
  }
  settle();
}

void World::take(const Choice& choice) {
  seen_ = StateHash(now());
  if (is_told_) {
    tell("-- " + to_text(choice));
  }
  switch (choice.act) {
    case Act::pass: pass(); break;
    case Act::ask: ask(choice.ask); break;
    case Act::leave:
      arrive(choice.which, Act::answer);
      is_left_ = true;
      break;
    case Act::answer:
    case Act::damaged:
    case Act::twice:
    case Act::first:
    case Act::half:
    case Act::rest:
      arrive(choice.which, choice.act);
      if (!asleep_since_) {
        hand_in();
      }
      break;
    case Act::slow:
      slow_[choice.which] = true;
      --left_.faults;
      break;
    case Act::sleep:
      --left_.delays;
      asleep_since_ = now();
      oracle_.note_sleep();
      break;
    case Act::wake: asleep_since_.reset(); break;
    case Act::read: hand_in(); break;
    case Act::take: take_client(static_cast<std::uint8_t>(choice.which)); break;
  }
  settle();
  require(left_.faults <= bounds_.faults, "no more goes wrong than may");
}

void World::pass() {
  if (!asleep_since_ && is_due()) {
    hand_in();
    settle();
    miss(now());
    oracle_.note_judged(now());
    harness_.handle(gateway::DeadlineReached{});
    const auto wake = harness_.next_wake();
    if (wake && wake->at <= now() && harness_.gateway().poll_action() == std::nullopt) {
      oracle_.report("no progress: a deadline stays due");
    }
    return;
  }
  const auto next = next_instant();
  if (!asleep_since_) {
    oracle_.note_passing(now(), left_.faults == bounds_.faults && left_.delays == bounds_.delays);
  }
  go_on(*next);
}

// What has not come until then comes late, or never.
void World::miss(Instant until) {
  for (Flight& flight : oracle_.flights()) {
    if (is_missed(flight, until)) {
      flight.outstanding = flight.outstanding && !is_slow(flight);
      flight.late = true;
      flight.spoilt = flight.spoilt || flight.rest_comes;
      flight.rest_comes = false;
      --left_.faults;
    }
  }
}

// A stop has ended the wait for it, or nothing lay on the line when it was to come at the latest.
void World::lose(Flight& flight) {
  if (flight.outstanding && !flight.late) {
    flight.late = true;
    is_beyond_ = is_beyond_ || left_.faults == 0;
    left_.faults -= left_.faults == 0 ? 0U : 1U;
  }
}

void World::go_on(Instant to) {
  miss(to - Duration{1});
  for (Flight& flight : oracle_.flights()) {
    flight.outstanding = flight.outstanding && (to <= closes(flight) || !flight.late);
  }
  harness_.go_on(to);
  require(now() - begun_ < kFarPast, "no world lives longer");
}

void World::ask(const Ask& ask) {
  --left_.requests;
  clients_ = std::max<std::uint8_t>(clients_, ask.client + 1U);
  devices_ = std::max<std::uint8_t>(devices_, ask.device + 1U);
  has_read_ = has_read_ || ask.is_read();
  const std::size_t slot = oracle_.note_asked(ask, now());
  const Octets pdu = pdu_of(ask.word, static_cast<std::uint16_t>(kFirstValue + slot));
  const Octets adu = world::tcp_adu(static_cast<std::uint16_t>(slot),
                                    static_cast<std::uint8_t>(ask.device + 1U), pdu);
  Octets& socket = sockets_[ask.client];
  socket.insert(socket.end(), adu.begin(), adu.end());
  if (!asleep_since_) {
    is_left_ = false;
    take_client(ask.client);
  }
}

void World::take_client(std::uint8_t client) {
  const Octets bytes = std::exchange(sockets_[client], {});
  oracle_.note_taken(client, now());
  harness_.handle(gateway::ClientBytes{client_id(client), bytes});
}

void World::arrive(std::uint16_t serial, Act form) {
  std::vector<Flight>& flights = oracle_.flights();
  Flight& flight = flights[serial];
  // A device answers in order: what it has not answered before never comes. But second answers do,
  // which are those of another device, or stay on the way for longer.
  for (Flight& other : flights) {
    if (!other.outstanding || other.device != flight.device || other.first_at || flight.first_at) {
      continue;
    }
    if (other.serial < serial) {
      left_.faults -= other.late ? 0U : 1U;
      other.outstanding = false;
      other.late = true;
    }
    other.begins = std::max(other.begins, now());
  }
  Octets frame = answer_of(flight);
  flight.outstanding = form == Act::first;
  flight.late = flight.late || form == Act::first;
  const auto middle = frame.begin() + static_cast<std::ptrdiff_t>(frame.size() / 2);
  switch (form) {
    case Act::damaged: frame.back() ^= 0x40U; break;
    case Act::twice: frame.insert(frame.end(), frame.begin(), frame.end()); break;
    case Act::first: flight.first_at = now(); break;
    case Act::half:
      frame.erase(middle, frame.end());
      flight.half_at = now();
      flight.rest_comes = true;
      break;
    case Act::rest:
      frame.erase(frame.begin(), middle);
      flight.rest_comes = false;
      break;
    default: break;
  }
  const bool is_good = form == Act::answer || form == Act::rest;
  left_.faults -= !is_good ? 1U : 0U;
  kernel_.insert(kernel_.end(), frame.begin(), frame.end());
  pieces_.push_back({serial, form});
}

// What lies in the line's descriptor.
void World::hand_in() {
  if (kernel_.empty()) {
    return;
  }
  const Octets bytes = std::exchange(kernel_, {});
  is_left_ = false;
  for (const Piece& piece : std::exchange(pieces_, {})) {
    Flight& flight = oracle_.flights()[piece.serial];
    if (piece.form == Act::damaged) {
      oracle_.note_damaged(flight, now());
    } else if (piece.form != Act::half) {
      oracle_.note_heard(flight, now());
    }
  }
  oracle_.note_bytes(now());
  harness_.handle(gateway::LineBytes{kLine, bytes});
}

void World::settle() {
  harness_.drain([this](const gateway::Action& action) { handle(action); });
  for (const gateway::ClientId client : std::exchange(written_, {})) {
    harness_.handle(gateway::ClientSent{client});
  }
  require(!harness_.gateway().poll_action().has_value(),
          "nothing follows when an answer is written");
}

void World::handle(const gateway::Action& action) {
  if (is_told_) {
    tell(test::action_text(action, harness_.settings()));
  }
  if (const auto* send = std::get_if<gateway::Send>(&action)) {
    const Octets adu(send->adu.begin(), send->adu.end());
    const auto client = static_cast<std::uint8_t>(static_cast<std::uint64_t>(send->client) - 1U);
    seen_.add(client);
    seen_.add(world::word_at(adu, 0));
    seen_.add(adu.back());
    seen_.add(adu.size());
    oracle_.note_sent(client, adu, now());
    written_.push_back(send->client);
  } else if (const auto* transmit = std::get_if<gateway::Transmit>(&action)) {
    const Octets frame(transmit->frame.begin(), transmit->frame.end());
    seen_.add(std::span(frame));
    for (Flight& flight : oracle_.flights()) {  // the line was looked at, and nothing lay there
      if (now() >= closes(flight) && (flight.late || is_slow(flight))) {
        lose(flight);
        flight.outstanding = false;
      }
    }
    oracle_.note_transmitted(frame, now());
    if (const auto cut = oracle_.take_cut()) {
      Flight& flight = oracle_.flights()[*cut];
      if (!is_slow(flight)) {
        lose(flight);
      }
    }
  } else if (std::holds_alternative<gateway::Look>(action)) {
    hand_in();
    harness_.handle(gateway::LineLooked{kLine});
  } else if (std::holds_alternative<gateway::Open>(action)) {
    harness_.handle(gateway::LineOpened{kLine});
  } else if (!std::holds_alternative<gateway::Report>(action)) {
    oracle_.report("an action that no small world has");
  }
}

Digest World::digest() {
  StateHash hash(now());
  read_state(harness_.gateway(), hash);
  oracle_.read(hash);
  hash.add(left_.requests);
  for (const Octets& socket : sockets_) {
    hash.add(std::span(socket));
  }
  for (const Piece& piece : pieces_) {
    hash.add(piece.form);
    hash.ordered(Order::event, oracle_.flights()[piece.serial].event);
  }
  hash.add(pieces_.size());
  hash.add(is_left_);
  hash.add(asleep_since_.has_value());
  hash.since(asleep_since_.value_or(now()), kFarPast);
  hash.add(clients_);
  hash.add(devices_);
  hash.add(has_read_);
  std::ranges::for_each(slow_, [&](bool is_slow) { hash.add(is_slow); });
  return hash.digest();
}

void World::tell(const std::string& text) const {
  const auto since = std::chrono::duration<double, std::milli>(now() - begun_);
  std::printf("%14.6f ms  %s\n", since.count(), text.c_str());
}

}  // namespace mbgate::explore
