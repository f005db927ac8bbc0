// SPDX-License-Identifier: Apache-2.0
#include "soak/refusals.hpp"

#include <algorithm>
#include <string>
#include <string_view>

#include "soak/identity.hpp"
#include "soak/oracle.hpp"
#include "soak/withdrawals.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

namespace {

std::string us(Duration time) { return std::to_string(time / 1us) + " us"; }

}  // namespace

void Refusals::note(const char* code, const char* reason) const {
  ++oracle_.report_.reasons[std::string(code) + "_" + reason];
}

bool Refusals::has_expired(const Asked& asked) const {
  return asked.deadline != Instant::max() &&
         oracle_.schedule_.now() >= asked.deadline - (asked.written - asked.earliest);
}

void Refusals::judge_busy(const Asked& asked) const {
  if (asked.surely_on_wire && oracle_.is_apart(asked, "refused_")) {
    return;  // by an exception to something else
  }
  if (asked.surely_on_wire) {
    oracle_.violation("busy_after_wire", oracle_.name(asked));
    return;
  }
  const char* reason = why_busy(asked);
  if (reason == nullptr && oracle_.rates_.is_refused(asked, oracle_.schedule_.now())) {
    reason = "rate";
  }
  if (reason != nullptr) {
    return note("06", reason);
  }
  const Instant now = oracle_.schedule_.now();
  oracle_.violation("busy_without_reason", oracle_.name(asked) + ", deadline " +
                                               us(asked.deadline - now) + " from now, as old as " +
                                               us(now - asked.earliest) + ", accepted " +
                                               us(now - asked.accepted) + " ago");
}

const char* Refusals::why_busy(const Asked& asked) const {
  if (const char* reason = why_withdrawn(asked); reason != nullptr) {
    return reason;
  }
  const auto any = [&](const auto& is_so) { return std::ranges::any_of(asked.pieces, is_so); };
  if (any([&](const Piece& piece) { return found_no_room(asked, piece.bus); })) {
    return "queue_full";
  }
  if (oracle_.writers_.may_be_held(asked, oracle_.schedule_.now())) {
    return "writer";
  }
  if (oracle_.stopping_ && !goes_at_the_end(asked)) {
    return "shutdown";
  }
  if (oracle_.has_failsafe(asked.pieces.front().bus)) {
    return "failsafe";  // it is taken back, as by any stop
  }
  const bool asks_order =
      any([](const Piece& piece) { return piece.asks_order && piece.sent > 0; });
  return asks_order && fault_of(asked) != nullptr ? "word_order_unknown" : nullptr;
}

// A stop of one device is sent until the gateway has finished, or has no time any more.
bool Refusals::goes_at_the_end(const Asked& asked) const {
  return asked.kind == Kind::stop && !is_away(asked) && !oracle_.finished_ &&
         oracle_.schedule_.now() < *oracle_.stopping_ + kGrace;
}

// It must not be transmitted any more.
const char* Refusals::why_withdrawn(const Asked& asked) const {
  if (asked.doomed || Withdrawals(oracle_).may_be_stopped(asked)) {
    return "stopped";
  }
  if (has_expired(asked)) {
    return "expired";
  }
  if (asked.dropped) {
    return "half_closed";
  }
  if (std::ranges::any_of(asked.pieces, &Piece::taken_back)) {
    return "taken_back";
  }
  if (asked.changes() && oracle_.reloaded_ == oracle_.schedule_.now()) {
    return "rights";
  }
  // It may have lain in a socket that was not read, since before its drive meant something else.
  return oracle_.is_outdated(asked) ? "outdated" : nullptr;
}

// It is told at once: that there is no room for it, or that it has lost its place to another one.
bool Refusals::found_no_room(const Asked& asked, std::size_t bus) const {
  const Book& book = oracle_.books_[bus];
  if (asked.is_stop()) {
    return asked.found_no_room;
  }
  // A write that waits makes room for nobody.
  const bool is_new = asked.is_read() || asked.kind == Kind::broadcast || asked.ordered ||
                      asked.ahead || asked.accepted + oracle_.lateness() >= oracle_.schedule_.now();
  const Instant since = asked.ordered ? asked.accepted : oracle_.schedule_.now();
  return is_new && (book.last_full >= since || book.present > oracle_.bus_settings(bus).queue);
}

void Refusals::judge_no_response(const Asked& asked) const {
  const bool was_asked_only =
      asked.changes() && std::ranges::none_of(asked.pieces, [](const Piece& it) {
        return it.sent > 0 && !it.asks_order;
      });
  if ((!asked.maybe_on_wire || was_asked_only) &&
      !(asked.is_read() && oracle_.may_be_offline(asked))) {
    oracle_.violation("no_response_without_wire", oracle_.name(asked));
    return;
  }
  if (asked.kind == Kind::broadcast && found_no_path(asked)) {
    oracle_.violation("no_response_without_path", oracle_.name(asked));
    return;
  }
  judge_tries(asked);
  if (const char* reason = why_no_response(asked); reason != nullptr) {
    note("0B", reason);
    return;
  }
  if (const char* reason = why_unfinished(asked); reason != nullptr) {
    note("0B_part", reason);
    return;
  }
  const Flight* last = oracle_.flight(asked.last_flight);
  if (last != nullptr && last->came > 0) {
    note("0B", "misfit");  // good frames, or what may be parts of them
    return;
  }
  std::string text = oracle_.name(asked);
  if (last != nullptr) {
    text += ", transmitted " + us(oracle_.schedule_.now() - last->begin) + " ago, deadline " +
            us(last->deadline - oracle_.schedule_.now()) + " from now, " +
            std::to_string(last->came) + " bytes came" + (last->is_answered ? ", answered" : "");
  }
  oracle_.violation("no_response_without_reason", text);
}

// What its drive cannot do now it is asked for again, as often as if it had not answered.
void Refusals::judge_refused_stop(const Asked& stop, std::uint8_t code) const {
  note("stop", is_not_now(code) ? "refused" : "denied");
  if (is_not_now(code)) {
    judge_tries(stop);
  }
}

// A stop is repeated until it has a fitting echo, but not on a line that is never silent.
void Refusals::judge_tries(const Asked& stop) const {
  const Piece& piece = stop.pieces.front();
  const bool is_judged = stop.kind == Kind::stop && stop.is_repeated && !stop.is_shared &&
                         !stop.ordered && stop.door->device && stop.flights == stop.flights_alone &&
                         !oracle_.stopping_;
  const Instant busy_since = oracle_.books_[piece.bus].busy_since;
  if (!is_judged || oracle_.may_be_offline(stop) || is_away(stop) ||
      oracle_.reloaded_ >= stop.accepted || oracle_.is_tcp(piece.bus) ||
      oracle_.schedule_.now() >= busy_since + oracle_.stop_deadline(piece.bus)) {
    return;
  }
  const unsigned retries = oracle_.devices_[*stop.door->device].settings().timing.stop_retries;
  if (piece.sent < 1 + retries) {
    oracle_.violation("stop_given_up",
                      oracle_.name(stop) + " after " + std::to_string(piece.sent) + " tries");
  }
}

const char* Refusals::why_no_response(const Asked& asked) const {
  if (const char* fault = fault_of(asked); fault != nullptr) {
    return fault;
  }
  return asked.is_read() && oracle_.may_be_offline(asked) && !asked.surely_on_wire ? "offline"
                                                                                   : nullptr;
}

// If the read that it was merged into, or that others were merged into, is refused, its own is
// still to be transmitted.
bool Refusals::was_merged(const Asked& asked) const {
  const auto& piece = asked.pieces.front();
  const bool may_merge = oracle_.bus_settings(piece.bus).merge ||
                         asked.accepted <= oracle_.books_[piece.bus].last_merge;
  return std::ranges::any_of(asked.tries, [&](std::uint64_t number) {
    const Flight* flight = oracle_.flight(number);
    return flight != nullptr && may_merge && (flight->pdu != piece.pdu || flight->asked.size() > 1);
  });
}

// What was transmitted of it has ended well, and the rest must not follow.
const char* Refusals::why_unfinished(const Asked& asked) const {
  const bool is_merged = was_merged(asked);
  if (asked.pieces.size() == 1 && !is_merged) {
    return nullptr;
  }
  const auto any = [&](const auto& is_so) { return std::ranges::any_of(asked.pieces, is_so); };
  if (any([](const Piece& piece) { return piece.doomed.has_value(); })) {
    return "stopped";
  }
  if (const char* reason = why_withdrawn(asked); reason != nullptr) {
    return reason;
  }
  if (asked.kind == Kind::broadcast ? was_cut_short(asked) : is_away(asked)) {
    return "line_away";
  }
  if (asked.is_read() && oracle_.may_be_offline(asked)) {
    return "offline";
  }
  const bool found_none = any([&](const Piece& piece) {
    return asked.kind == Kind::broadcast
               ? oracle_.books_[piece.bus].last_full >= asked.accepted
               : is_merged && found_no_room(asked, piece.bus);  // it waits once more
  });
  if (found_none) {
    return "queue_full";
  }
  return oracle_.stopping_ ? "shutdown" : nullptr;
}

// Of a request that was transmitted by itself, what befell its last try; otherwise any of those
// that it may have been among.
const char* Refusals::fault_of(const Asked& asked) const {
  for (auto number = asked.tries.rbegin(); number != asked.tries.rend(); ++number) {
    const Flight* flight = oracle_.flight(*number);
    if (flight == nullptr) {
      return "long_ago";
    }
    const char* fault = fault_of(*flight);
    if (fault != nullptr || asked.last_alone == *number) {
      return fault;
    }
  }
  return nullptr;
}

const char* Refusals::fault_of(const Flight& flight) const {
  const Book& book = oracle_.books_[flight.bus];
  if (flight.is_cut_off || book.last_down >= flight.begin) {
    return "line_lost";
  }
  if (flight.is_answered) {
    return flight.is_stop && flight.refused ? "refused" : nullptr;
  }
  if (flight.unsure != nullptr) {
    return flight.unsure;
  }
  const bool is_only_echo = flight.has_whole_echo && flight.came == flight.size &&
                            !flight.echo_pauses &&
                            !spec::is_opaque(flight.pdu);  // silence within its echo ends that
  return flight.is_named && !is_only_echo && !flight.is_broadcast ? "damaged" : end_of_wait(flight);
}

// From outside nobody sees which stop waits: one that was accepted, or sent and not acknowledged.
bool Refusals::may_be_cut(const Flight& flight) const {
  const Instant last = oracle_.books_[flight.bus].last_stop;
  if (oracle_.has_failsafe(flight.bus)) {
    return true;
  }
  return flight.beside_stop || flight.meets_stop ||
         (flight.is_stop ? last > flight.begin : last >= flight.begin);
}

// Nothing came that could end the wait for its answer.
const char* Refusals::end_of_wait(const Flight& flight) const {
  const Instant now = oracle_.schedule_.now();
  if (!flight.expects_answer) {  // silence is what its client waits for
    return oracle_.stopping_ && now >= *oracle_.stopping_ + kGrace ? "shutdown" : nullptr;
  }
  const bool may_be = !oracle_.is_tcp(flight.bus) || oracle_.has_failsafe(flight.bus);
  if (now < flight.due && may_be && may_be_cut(flight)) {
    return "cut_by_stop";
  }
  if (now >= oracle_.deadline_of(flight)) {
    return flight.came == 0                      ? "timeout"
           : flight.first_came < flight.deadline ? "unreadable"
                                                 : "late";
  }
  return oracle_.stopping_ && now >= *oracle_.stopping_ + kGrace ? "shutdown" : nullptr;
}

}  // namespace mbgate::soak
