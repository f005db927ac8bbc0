// SPDX-License-Identifier: Apache-2.0
// Which request a transmission is for, and whether it may be transmitted now.
#include <algorithm>

#include "soak/oracle.hpp"
#include "soak/shared_reads.hpp"
#include "soak/withdrawals.hpp"

namespace mbgate::soak {
namespace {

// A part of several goes only when those before it were carried out. Which word order the drive has
// may be known from an earlier question; it may have been when this was sent the first time.
bool is_behind_failure(const Asked& asked, const Piece& piece, const Lane& lane) {
  if (asked.kind == Kind::broadcast || &piece == &asked.pieces.front()) {
    return false;
  }
  const Piece& before = *(&piece - 1);
  return !before.executed && !(before.asks_order && (lane.knows_order || piece.sent > 0));
}

// What the gateway does itself in one instant has no order: it may have been transmitted for those
// whose connections the gateway has closed since.
std::vector<std::uint64_t> just_closed(const auto& done, const Flight& flight, Instant now) {
  std::vector<std::uint64_t> ids;
  for (const Done& it : done) {
    if (it.how == kClosed && it.at == now && it.bus == flight.bus && it.address == flight.address &&
        it.pdu == flight.pdu) {
      ids.push_back(it.id);
    }
  }
  return ids;
}

}  // namespace

bool Oracle::fits(const Asked& asked, const Piece& piece, const Flight& flight) const {
  if (piece.pdu == flight.pdu) {
    return true;
  }
  const bool may_merge = bus_settings(flight.bus).merge ||
                         (asked.is_accepted && asked.accepted <= books_[flight.bus].last_merge);
  if (!may_merge || !asked.is_read() || asked.pieces.size() > 1 ||
      piece.pdu.front() != flight.pdu.front() || piece.pdu.size() != 5 || flight.pdu.size() != 5) {
    return false;
  }
  const unsigned first = spec::word_at(piece.pdu, 1);
  const unsigned merged = spec::word_at(flight.pdu, 1);
  return first >= merged &&
         first + spec::word_at(piece.pdu, 3) <= merged + spec::word_at(flight.pdu, 3);
}

// Why the piece may not be transmitted now; nothing if it may.
std::string Oracle::objection(const Asked& asked, const Piece& piece) {
  const Instant now = schedule_.now();
  const drive::DeviceTiming timing =
      asked.door->device ? devices_[*asked.door->device].settings().timing : drive::DeviceTiming{};
  if (piece.taken_back) {
    return "other_meaning";
  }
  if (asked.is_stop()) {
    const unsigned repeats =
        asked.is_repeated ? std::max(asked.stop_retries, timing.stop_retries) : 0;
    return asked.surely_on_wire && !asked.is_shared && reloaded_ < asked.accepted &&
                   piece.sent > repeats
               ? "stop_too_often"
               : "";
  }
  if (!asked.is_accepted) {
    return "pipeline";
  }
  if (stopping_ && now > *stopping_) {
    return "after_shutdown";
  }
  if (asked.dropped && piece.sent == 0) {
    return "for_half_closed_client";
  }
  if (now >= asked.deadline) {
    return "late_command";
  }
  const auto doomed = asked.doomed ? asked.doomed : piece.doomed;
  if (doomed && now > *doomed && piece.sent == 0) {
    return "cancelled_write";
  }
  const bool once = asked.changes() && !asked.retry_writes;
  if (asked.other_order && !piece.asks_order) {
    return "written_in_other_order";
  }
  if (is_behind_failure(asked, piece, books_[piece.bus].lanes[piece.address]) &&
      !is_apart(asked, "continued_")) {
    return "part_after_failure";
  }
  if (asked.changes() && !piece.asks_order && piece.sent > (once ? 0 : asked.retries)) {
    return "write_twice";
  }
  return "";
}

// Takes the requests that the frame may be for and speaks against none of them.
void Oracle::attribute(Flight& flight) {
  const Lane& lane = books_[flight.bus].lanes[flight.address];
  SharedReads::Meant meant;
  std::string against;
  for (Asked* asked : lane.open) {
    for (Piece& piece : asked->pieces) {
      if (piece.bus != flight.bus || !fits(*asked, piece, flight)) {
        continue;
      }
      const std::string reason = objection(*asked, piece);
      if (reason.empty()) {
        meant.emplace_back(asked, &piece);
        break;
      }
      if (against.empty()) {
        against = reason + "|" + name(*asked);
      }
    }
  }
  if (meant.empty() && !against.empty()) {
    const auto border = against.find('|');
    violation(against.substr(0, border), name(flight) + " for " + against.substr(border + 1));
  } else if (meant.empty() && is_failsafe(flight.pdu)) {
    note_failsafe_sent(flight);
  } else if (meant.empty()) {
    unknown_transmission(flight);
  }
  SharedReads(*this).count_tries(flight, meant);
  SharedReads(*this).note_writes(flight, meant);
  const auto closed = just_closed(done_, flight, schedule_.now());
  flight.is_for_each = flight.is_for_each && closed.empty();
  for (const auto& [asked, piece] : meant) {
    const bool alone = (meant.size() == 1 && closed.empty()) || flight.is_for_each;
    flight.asked.push_back(asked->id);
    if (alone) {
      Withdrawals(*this).note_taken(*asked);
      Withdrawals(*this).note_passed(*asked);
    }
    note_sent(*asked, *piece, flight, alone);
  }
  if (!meant.empty()) {
    flight.asked.insert(flight.asked.end(), closed.begin(), closed.end());
  }
}

void Oracle::unknown_transmission(Flight& flight) {
  for (auto done = done_.rbegin(); done != done_.rend(); ++done) {
    if (done->bus == flight.bus && done->address == flight.address && done->pdu == flight.pdu) {
      // What the gateway does itself in one instant has no order.
      flight.repeats_read = true;
      if (done->how != kClosed || done->at < schedule_.now()) {
        violation(done->how, name(flight));
      }
      return;
    }
  }
  violation("unknown_transmission", name(flight));
}

void Oracle::note_sent(Asked& asked, Piece& piece, const Flight& flight, bool alone) {
  Flight& mine = const_cast<Flight&>(flight);
  mine.is_stop = mine.is_stop || asked.is_stop();
  mine.is_repeated = mine.is_repeated || asked.is_repeated;
  mine.asks_order = mine.asks_order || piece.asks_order;
  mine.expects_answer = mine.expects_answer && !asked.silent && asked.kind != Kind::broadcast;
  const bool is_part_of_merged = asked.is_read() && asked.flights_alone == 0 &&
                                 !asked.last_sent.empty() && asked.last_sent != flight.pdu;
  if (alone && is_part_of_merged && asked.pieces.size() == 1 && !is_tcp(flight.bus)) {
    check_order(asked, flight);
  }
  if (alone && !asked.maybe_on_wire && !asked.is_stop()) {
    check_order(asked, flight);
    if (asked.kind == Kind::broadcast && !asked.ordered && !asked.ahead) {
      SharedReads(*this).check_overtaken(asked, flight);
    }
    if (const std::string owner = writers_.sent(asked, schedule_.now()); !owner.empty()) {
      violation("writer", name(asked) + ", but " + owner);
    }
  }
  mine.repeats_read =
      mine.repeats_read || ((asked.is_read() || piece.asks_order) && asked.last_sent == flight.pdu);
  mine.is_part = mine.is_part || (asked.pieces.size() > 1 && asked.kind != Kind::broadcast);
  mine.surely_repeats =
      alone && mine.repeats_read && asked.last_alone != 0 && asked.pieces.size() == 1;
  if (mine.surely_repeats || (alone && asked.kind == Kind::stop && !asked.is_shared)) {
    check_answered(asked);
    check_pause(asked, flight);
  }
  asked.last_alone = alone ? flight.number : 0;
  asked.flights_alone += alone ? 1U : 0U;
  check_tries(asked);
  asked.last_flight = flight.number;
  asked.tries.push_back(flight.number);
  asked.last_sent = flight.pdu;
  ++asked.flights;
  ++piece.sent;
  // Of several that wait only one may have been transmitted before.
  if (asked.is_stop() && (piece.sent == 1 || !asked.surely_on_wire)) {
    mine.stop_from = std::min(mine.stop_from.value_or(asked.accepted), asked.accepted);
  }
  leave_queue(asked.pieces.size() == 1 || asked.kind == Kind::broadcast ? piece
                                                                        : asked.pieces.front());
  asked.maybe_on_wire = true;
  asked.surely_on_wire = asked.surely_on_wire || (alone && !piece.asks_order);
  note_write_event(asked, flight.bus);
  // The next form of a broadcast waits as the first did.
  const bool is_whole = std::ranges::all_of(asked.pieces, [&](const Piece& it) {
    return it.bus != flight.bus || it.sent > 0 || it.taken_back || &it == &piece;
  });
  if (is_whole) {
    std::erase(books_[flight.bus].stops, &asked);
  } else if (asked.waits_from) {
    asked.waits_from = schedule_.now();
  }
  if (!asked.replies &&
      std::ranges::all_of(asked.pieces, [](const Piece& it) { return it.sent > 0; })) {
    end_without_reply(asked);
  }
}

}  // namespace mbgate::soak
