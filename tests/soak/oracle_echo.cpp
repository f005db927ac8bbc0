// SPDX-License-Identifier: Apache-2.0
// What a line hears of itself, and what begins before a request has left: when an echo may be taken
// for an answer, and when it must not.
//
// The echo of 05, 06, 08, 21, 22 and of a function of the maker's own looks like the answer. On an
// `echo = "auto"` line it may be taken for it until the echo of anything else came whole; where the
// settings deny an echo that there is, always; where they say that there is one, never; and nowhere
// if the line is paced and it was read before the computed end of the request. That of some reads
// of bits looks like an answer too: only settings that deny it make it one. Answers to requests
// without fields may begin as their echoes would: these prove nothing.
#include <algorithm>

#include "soak/oracle.hpp"

namespace mbgate::soak {
namespace {

constexpr const char* kUnproven = "unproven_echo";
constexpr unsigned kMostLost = 3;  // in a row; then an echo is not proven any more

// As long as an answer to 15 or 16, whose echo begins as it does.
bool ends_like_answer(const Flight& flight, std::size_t read) {
  constexpr std::size_t kAnswer = 8;
  const std::uint8_t function = flight.pdu.front();
  const auto fields = spec::fields_of(flight.pdu);
  const bool is_plain_read = fields && fields->reads && !fields->writes;
  return is_plain_read
             ? flight.pdu[1] == spec::data_size_of(*fields->reads) && read == flight.pdu[1] + 5U
             : read == kAnswer && (function == 0x0F || function == 0x10);
}

// The request for registers has five bytes; as a response it would say so by its byte count.
bool is_no_response(const PduBytes& pdu) {
  constexpr std::uint8_t kBytes = 3;
  return (pdu[0] == 0x03 || pdu[0] == 0x04) && pdu[1] != kBytes;
}

// For as long as for an answer; what makes a device boot has only the turnaround delay.
bool is_waited_for(const Flight& flight) {
  return flight.expects_answer || is_listen_only(flight.pdu);
}

}  // namespace

// At the end, or because the line is opened anew.
void Oracle::check_told(const Book& book, std::size_t bus) const {
  if (book.must_tell_unproven && !book.told_unproven) {
    violation("not_told", "an answer that may be an echo on " + bus_settings(bus).name);
  }
  if (book.must_tell_denied && !book.told_denied) {
    violation("not_told", "an echo that the settings deny on " + bus_settings(bus).name);
  }
}

// The first byte was read before the computed end of the own transmission.
bool Oracle::began_while_sending(std::size_t bus, Instant began) const {
  return is_paced(plan_, bus) && began <= books_[bus].read_while_sending;
}

// What it is shows only when it is read.
void Oracle::frame_came(std::size_t bus, HeardFrame frame) {
  Book& book = books_[bus];
  if (const Flight* from = flight(frame.flight);
      frame.is_second && from != nullptr && !from->paid_at) {
    frame.is_second = frame.is_nobodys = false;  // nothing was heard of the first one
  }
  book.lanes[frame.address].forget_silence();
  // They settle what is owed in the order in which they came.
  const bool waits = std::ranges::any_of(book.unread, &HeardFrame::waits) ||
                     (is_paced(plan_, bus) && schedule_.now() < book.own_end) ||
                     began_while_sending(bus, frame.began);
  book.unread.push_back(frame);
  note_whole(bus, book.unread.back());
  book.unread.back().waits = waits;
  if (!waits) {
    settle(bus, frame);
  }
}

void Oracle::read_frames(std::size_t bus) {
  Book& book = books_[bus];
  if (schedule_.now() < book.own_end) {
    book.read_while_sending = schedule_.now();
  }
  book.requests_heard += book.unread_stranger ? 1U : 0U;
  book.is_strange = book.is_strange || std::exchange(book.unread_stranger, false);
  for (HeardFrame& frame : std::exchange(book.unread, {})) {
    frame.is_refused = is_for_last(book, frame) && began_while_sending(bus, frame.began);
    book.is_strange = book.is_strange || frame.is_refused || frame.is_nobodys;
    if (frame.waits) {
      settle(bus, frame);
    }
    note_answered(bus, frame);
    note_heard(book, frame);
  }
}

// The gateway may take it for the answer to what it has transmitted last.
bool Oracle::is_for_last(const Book& book, const HeardFrame& frame) {
  const Flight* last = flight(book.last_flight);
  const Flight* from = flight(frame.flight);
  return frame.fits && last != nullptr && last->address == frame.address &&
         frame.began >= last->begin && (from == nullptr || may_be_confused(from->pdu, last->pdu));
}

// An answer may be taken for the echo of what was transmitted last, and that for the answer: both
// are the same, and one is the device's.
bool Oracle::stands_for_echo(const Book& book) {
  const Flight* last = flight(book.last_flight);
  return plan_.echoes[last->bus] && looks_like_answer(*last) &&
         bus_settings(last->bus).line.echo.value_or(true);
}

void Oracle::read_echo(std::size_t bus) {
  Book& book = books_[bus];
  const auto echo = std::exchange(book.unread_echo, std::nullopt);
  Flight* last = flight(book.last_flight);
  const auto& settings = bus_settings(bus);
  const std::size_t read = std::exchange(book.read, book.came);
  const Duration pause = std::max(spec::slack_of(settings), spec::silence_of(settings));
  // Where it was not denied, it is held back for its rest as long as its answer is waited for.
  const bool is_held_back =
      last != nullptr &&
      schedule_.now() < (is_waited_for(*last) ? last->due : last->end + settings.turnaround);
  const bool is_told = settings.line.echo == false || (!settings.line.echo && !is_held_back);
  if (last != nullptr && is_told && ends_like_answer(*last, read) &&
      schedule_.now() >= book.last_handed_in + pause) {
    last->echo_pauses = true;  // silence has ended what looked like an answer with a bad CRC
  }
  book.requests_heard += echo ? 1U : 0U;
  if (!echo || last == nullptr || last->number != echo->flight) {
    return;
  }
  last->has_whole_echo = echo->is_whole;
  if (last->pdu.size() == 1) {
    return;
  }
  if (looks_like_answer(*last)) {
    if (echo->is_whole) {
      note_echo_for_answer(bus, *last, *echo);
    }
    return;
  }
  // Nothing stood before it, and the wait for the answer was not over yet.
  const Instant over = is_waited_for(*last) ? last->deadline : last->end + settings.turnaround;
  const bool is_plain = echo->is_whole && book.came == echo->size && book.open_stops.empty() &&
                        (last->is_broadcast || schedule_.now() < over);
  book.since_echo = is_plain ? 0 : book.since_echo;
  if (is_plain && !bus_settings(bus).line.echo && !std::exchange(book.echo_proven, true)) {
    report_.fault("echo_proven");
  }
  book.denied_echo = is_plain && echo->in_one && bus_settings(bus).line.echo == false &&
                     !last->is_broadcast && is_no_response(last->pdu);
  // Two that are a minute apart prove nothing.
  const bool is_soon = schedule_.now() < book.denied_at + std::chrono::seconds(50);
  book.must_tell_denied |= book.denied_echo && book.denied_before && is_soon;
  book.denied_at = book.denied_echo ? schedule_.now() : book.denied_at;
}

void Oracle::note_echo_for_answer(std::size_t bus, Flight& flight, const HeardEcho& echo) {
  Book& book = books_[bus];
  const auto& setting = bus_settings(bus).line.echo;
  if (!setting.value_or(false) && !book.echo_proven) {
    book.lanes[flight.address].forget_silence();  // it may be taken for a sign of life
  }
  for (const std::uint64_t id : flight.asked) {
    if (const auto entry = open_.find(id); entry != open_.end()) {
      entry->second->echoed = true;
    }
  }
  flight.may_be_paid = true;
  HeardFrame frame{flight.address, true, true, flight.number, echo.began};
  frame.is_refused = began_while_sending(bus, echo.began);
  if (setting.value_or(false) || (book.echo_proven && book.since_echo <= kMostLost) ||
      (!setting && !flight.is_write && !book.echo_lost) || frame.is_refused) {
    report_.fault("echo_refused");
    if (setting && !*setting) {
      frame.is_refused = true;
      settle(bus, frame);
    }
    return;
  }
  const bool is_late = schedule_.now() > flight.end + kAdapterHolds;
  frame.excuse = setting          ? "denied_echo"
                 : book.echo_lost ? "echo_after_a_lost_one"
                 : is_late        ? "late_echo"
                                  : kUnproven;
  report_.fault(frame.excuse);
  settle(bus, frame);
}

// A read that was answered, and nothing came of its echo: it shows that there is none.
void Oracle::echo_lost(const Flight& flight) {
  Book& book = books_[flight.bus];
  book.echo_lost = book.echo_lost || !looks_like_answer(flight);
}

// An echo may be its answer, by what the line has shown.
bool Oracle::is_excused(const Asked& asked) {
  return asked.echoed && is_apart(asked, "acknowledged_stop_");
}

// A good answer was heard after its request had left, or before on a line that is not paced.
void Oracle::judge_heard(const Asked& asked) {
  const bool is_asked = asked.kind != Kind::broadcast && asked.kind != Kind::own && !asked.silent &&
                        asked.maybe_on_wire && !asked.pieces.empty();
  if (!is_asked || is_tcp(asked.pieces.front().bus) ||
      std::ranges::all_of(asked.pieces,
                          [](const Piece& it) { return it.answered || it.asks_order; })) {
    return;
  }
  const bool may_be_cached =
      asked.is_read() &&
      std::max(asked.cache, devices_[*asked.door->device].settings().cache) > Duration{0};
  if (may_be_cached) {
    return;
  }
  if (is_apart(asked, "answered_")) {
    Book& book = books_[asked.pieces.front().bus];
    const bool is_of_this_line = asked.accepted >= book.opened;  // it may have been opened since
    // Of several parts one may have been echoed, and another one answered by the cache or not at
    // all.
    const bool is_plain = asked.pieces.size() == 1 && asked.flights == 1;
    book.must_tell_unproven |= is_plain && is_of_this_line && asked.uncertain == kUnproven;
    return;
  }
  if (asked.echoed && !bus_settings(asked.pieces.front().bus).line.echo) {
    return;  // its device was heard, and nobody knows yet what the line does
  }
  const char* kind = asked.echoed    ? "echo_taken"
                     : asked.hurried ? "answered_while_sending"
                                     : "answer_unheard";
  violation(kind, name(asked));
}

// An answer that began before its request had left showed an echo where there is none; only reads
// show that, and a device that answers nothing in time is not asked for any.
bool Oracle::takes_answers_for_echoes(std::size_t bus) const {
  return books_[bus].echo_found && !plan_.echoes[bus];
}

void Oracle::line_news(std::size_t bus, bus::LineFault fault) {
  Book& book = books_[bus];
  const auto once = [&](bool& told, const char* kind) {
    report_.fault(kind);
    if (std::exchange(told, true)) {
      violation("told_twice", std::string(kind) + " of " + bus_settings(bus).name);
    }
  };
  if (fault == bus::LineFault::echo_found) {
    report_.fault("told_echo_found");
    book.echo_found = true;
    if (!plan_.echoes[bus] && !book.is_strange) {
      violation("echo_claimed", bus_settings(bus).name);
    }
  } else if (fault == bus::LineFault::echo_gone) {
    report_.fault("told_echo_gone");
    book.echo_found = false;
  } else if (fault == bus::LineFault::echo_denied) {
    once(book.told_denied, "told_echo_denied");
    // One may be the request of another client.
    if (!plan_.echoes[bus] || bus_settings(bus).line.echo != false || book.requests_heard < 2) {
      violation("told_wrongly", "a denied echo on " + bus_settings(bus).name);
    }
  } else if (fault == bus::LineFault::echo_unproven) {
    once(book.told_unproven, "told_echo_unproven");
  } else if (fault == bus::LineFault::answered_while_sending) {
    once(book.told_while_sending, "told_answered_while_sending");
    if (!is_paced(plan_, bus)) {
      violation("told_wrongly", bus_settings(bus).name);
    }
  }
}

}  // namespace mbgate::soak
