// SPDX-License-Identifier: Apache-2.0
// The oracle's judgement of an answer: data that the device held meanwhile, or an exception that
// the rules allow for what happened on the wire.
#include <algorithm>

#include "soak/oracle.hpp"
#include "soak/own_identity.hpp"
#include "soak/refusals.hpp"
#include "soak/shared_reads.hpp"
#include "soak/withdrawals.hpp"

namespace mbgate::soak {
namespace {

constexpr std::uint8_t kFailure = 0x04;
constexpr std::uint8_t kBusy = 0x06;
constexpr std::uint8_t kNoPath = 0x0A;
constexpr std::uint8_t kNoResponse = 0x0B;
constexpr Duration kStopMemory = std::chrono::seconds(2);  // as long as an answer may be owed

std::string code_text(unsigned code) {
  constexpr char kDigits[] = "0123456789ABCDEF";
  return {kDigits[code >> 4U & 15U], kDigits[code & 15U]};
}

// What the drive said of its word order was compared with settings that came meanwhile.
bool was_asked_before_reload(const Asked& asked) {
  return std::ranges::any_of(asked.pieces, [](const Piece& piece) {
    return piece.asks_order && piece.executed && piece.taken_back;
  });
}

// The acknowledgement of a stop may be that of the same stop a moment ago, which was carried out.
// Nothing was written in between that may move again what it stopped. What is written afterwards,
// while `ordered` keeps the answer from its client, says nothing of that.
bool was_stopped(const Asked& stop, const Lane& lane) {
  const auto entry = lane.stops_done.find(stop.pieces.front().pdu);
  return entry != lane.stops_done.end() && entry->second + kStopMemory >= stop.accepted &&
         entry->second >= lane.written_at;
}

}  // namespace

void Oracle::note_heard(Book& book, const HeardFrame& frame) {
  if (!is_for_last(book, frame)) {
    return;
  }
  const Flight* last = flight(book.last_flight);
  for (const std::uint64_t id : last->asked) {
    const auto entry = open_.find(id);
    if (entry == open_.end()) {
      continue;
    }
    Asked& asked = *entry->second;
    asked.hurried = asked.hurried || frame.is_refused;
    for (Piece& piece : asked.pieces) {
      if ((!frame.is_refused || stands_for_echo(book)) && fits(asked, piece, *last)) {
        piece.answered = true;
        asked.was_stopped = was_stopped(asked, book.lanes[frame.address]);
      }
    }
  }
}

void Oracle::judge(Asked& asked, Bytes pdu) {
  const std::uint8_t function = asked.pdu.front();
  if (pdu.size() < 2 || pdu[0] == function || pdu[1] != kBusy) {
    if (const std::string broken = rates_.let_through(asked); !broken.empty()) {
      violation("over_rate", broken + ": " + name(asked));
    }
  }
  if (const std::string broken = client_rates_.answered(asked, lateness(), schedule_.now());
      !broken.empty() && !stopping_) {
    violation(broken, name(asked));
  }
  // What was read while a write waited that was then never sent is what the device holds.
  if (std::ranges::any_of(asked.pieces, [](const Piece& it) { return it.sent > 0; })) {
    note_write_event(asked);
  }
  if ((pdu[0] & 0x80U) != 0 && pdu.size() == 2 && pdu[0] == (function | 0x80U)) {
    ++report_.exceptions;
    ++report_.codes[pdu[1]];
    judge_exception(asked, pdu[1]);
    close(asked, "after_answer_" + code_text(pdu[1]));
    return;
  }
  ++report_.answers;
  if (pdu[0] != function) {
    violation("wrong_function", "function " + std::to_string(pdu[0]) + " for " + name(asked));
  } else if (asked.refused || asked.other_order || !asked.replies) {
    violation("not_refused", name(asked));
  } else if (asked.kind == Kind::own) {
    own_answer_.assign(pdu.begin(), pdu.end());
    if (const auto objection = objection_to_identity(asked.pdu, pdu); !objection.empty()) {
      violation("own_identity", objection);
    }
  } else {
    judge_content(asked, pdu);
    judge_done(asked);
    judge_heard(asked);
    judge_place(asked);
    judge_cached(asked);
    SharedReads(*this).judge_joined(asked);
    if (asked.kind != Kind::broadcast && !asked.silent && asked.maybe_on_wire) {
      // Where the transmission may have been for another one, the cache may have answered it.
      const bool cached =
          asked.door->device && !asked.surely_on_wire &&
          std::max(asked.cache, devices_[*asked.door->device].settings().cache) > Duration{0};
      device_answered(asked, cached);
      if (asked.flights == asked.spoilt && !cached && !is_apart(asked, "after_wrong_echo_")) {
        violation("after_wrong_echo", name(asked));
      }
    }
    well_ = std::max(well_, std::optional(asked.id));
  }
  close(asked, "after_answer");
}

void Oracle::judge_exception(const Asked& asked, std::uint8_t code) {
  if (asked.refused) {
    if (*asked.refused != code && !Withdrawals(*this).may_come_before(asked, code)) {
      violation("wrong_refusal", code_text(code) + " instead of " + code_text(*asked.refused) +
                                     " for " + name(asked));
    }
    return;
  }
  if (asked.kind == Kind::own) {
    if ((asked.any_code && may_refuse_identity(asked.pdu, code)) ||
        (code == kBusy && rates_.is_refused(asked, schedule_.now()))) {
      return;
    }
    violation("wrong_refusal", code_text(code) + " of the status unit");
    return;
  }
  const Refusals refusals(*this);
  if (asked.kind == Kind::stop && asked.device_exceptions.test(code)) {
    refusals.judge_refused_stop(asked, code);
    return;
  }
  switch (code) {
    case kBusy:
      refusals.judge_busy(asked);
      if (asked.is_stop() && is_outdated(asked)) {
        Withdrawals(*this).give_back(asked);
      }
      judge_eviction(asked);
      return;
    case kNoPath: refusals.judge_no_path(asked); return;
    case kNoResponse:
      refusals.judge_no_response(asked);
      judge_cut(asked);
      check_answered(asked);
      judge_tries(asked);
      return;
    default: break;
  }
  const bool is_the_devices =
      asked.device_exceptions.test(code) || (code == kFailure && was_asked_before_reload(asked));
  if (!is_the_devices) {
    if (is_apart(asked, "misdelivered_")) {
      return;
    }
    violation("misdelivered_exception", code_text(code) + " for " + name(asked));
    return;
  }
  device_answered(asked, false);
}

void Oracle::device_answered(const Asked& asked, bool may_be_kept) {
  const Piece& piece = asked.pieces.front();
  const Book& book = books_[piece.bus];
  // What is held back says nothing of now, and what was kept nothing of the device; of connections
  // it is read. A request that the gateway took later than it could have may seem to be what was
  // transmitted meanwhile for another one.
  const bool is_kept = may_be_kept && book.use.fitting != schedule_.now();
  if (asked.ordered || is_kept || asked.last_flight != book.last_flight || is_tcp(piece.bus)) {
    return;
  }
  Lane& lane = books_[piece.bus].lanes[piece.address];
  note_alive(piece.bus, lane);
  lane.unanswered = 0;
}

bool Oracle::may_be_offline(const Asked& asked) const {
  if (!asked.door->device) {
    return false;
  }
  if (is_tcp(asked.pieces.front().bus)) {
    return true;  // 0A and 0B of the server say that it did not reach the device
  }
  const Lane& lane = books_[asked.pieces.front().bus].lanes[asked.pieces.front().address];
  return lane.last_offline >= asked.accepted || is_past_offline(asked.pieces.front().bus, lane);
}

// Between these instants the device must have held what the answer shows.
Span Oracle::span_of(const Asked& asked) const {
  if (asked.changes()) {
    return asked.pieces.back().done;  // 23 reads when it has written
  }
  const Duration cache = std::max(asked.cache, devices_[*asked.door->device].settings().cache);
  Instant first = asked.accepted;
  if (cache > Duration{0} && !asked.identity) {
    const Lane& lane = books_[asked.pieces.front().bus].lanes[asked.pieces.front().address];
    // Of what happens in one instant nobody outside can tell what came first.
    const Instant last_write = lane.last_write_event < asked.accepted ? lane.last_write_event
                               : lane.earlier_write_event < asked.accepted
                                   ? lane.earlier_write_event
                                   : Instant::min();
    first = std::max(asked.accepted - cache, last_write);
    first = lane.emptied_at < asked.accepted ? std::max(first, lane.emptied_for) : first;
    for (const Asked* write : lane.open) {
      if (write->changes() && !write->ordered && !write->ahead && !write->client_gone &&
          write->accepted < asked.accepted) {
        first = std::max(first, write->accepted);  // it waits: it was taken, and nothing kept since
      }
    }
  }
  return {first, schedule_.now()};
}

void Oracle::judge_done(const Asked& asked) {
  if (asked.is_read()) {
    return;
  }
  const auto all = [&](const auto& is_so) {
    return std::ranges::all_of(asked.pieces,
                               [&](const Piece& it) { return it.asks_order || is_so(it); });
  };
  const bool sent = all([](const Piece& it) { return it.sent > 0; });
  const bool done = all([](const Piece& it) { return it.executed; });
  const bool must_be_done = !asked.silent && asked.kind == Kind::write;
  if (!sent || (!done && must_be_done)) {
    if (is_apart(asked, "acknowledged_")) {
      return;
    }
    violation("write_not_done", name(asked));
  }
  if (asked.kind == Kind::stop && !done && !asked.was_stopped && !is_excused(asked) &&
      !is_apart(asked, "acknowledged_stop_")) {
    violation("stop_not_done", name(asked));
  }
}

// Physics gives no certainty whose answer it got, or what the cache was filled with.
bool Oracle::is_apart(const Asked& asked, const char* what) {
  const Lane& lane = books_[asked.pieces.front().bus].lanes[asked.pieces.front().address];
  const bool may_be_cached = asked.is_read() && lane.uncertain_at >= span_of(asked).first;
  if (asked.uncertain == nullptr && !may_be_cached) {
    return false;
  }
  ++report_.apart[std::string(what) + (asked.uncertain != nullptr ? asked.uncertain : "cached")];
  count_slip(asked);
  return true;
}

// Nobody is shown what was read before an earlier write of the same connection.
void Oracle::judge_place(const Asked& asked) {
  if (!asked.is_read()) {
    return;
  }
  const Piece& piece = asked.pieces.front();
  for (const Asked* other : books_[piece.bus].lanes[piece.address].open) {
    if (other->kind == Kind::write && other->client == asked.client &&
        other->sequence < asked.sequence && !other->maybe_on_wire && !other->doomed &&
        !other->dropped && is_surely_open(*other)) {
      violation("before_own_write", name(asked) + " was answered before " + name(*other));
    }
  }
}

}  // namespace mbgate::soak
