// SPDX-License-Identifier: Apache-2.0
// What devices owe, what a frame that came says of it, and where nobody can tell.
#include <algorithm>

#include "bus/health/device_health.hpp"
#include "soak/oracle.hpp"

namespace mbgate::soak {
namespace {

constexpr int kAnswerTimes = 4;  // after so many answer times an owed answer was not just late

// By its length a frame of the request's function is an answer to it: an exception, or what a read
// brings. Those to other requests have fields that no answer of another function fits.
bool has_length_of_answer(std::size_t size, const PduBytes& asked, bool is_ascii) {
  constexpr std::size_t kException = 2;
  const auto frame_of = [&](std::size_t pdu) { return is_ascii ? 2 * pdu + 7 : pdu + 3; };
  const auto fields = spec::fields_of(asked);
  if (spec::is_opaque(asked)) {
    return true;
  }
  if (size == frame_of(kException) || !fields || !fields->reads) {
    return size == frame_of(kException);
  }
  return size == frame_of(2 + spec::data_size_of(*fields->reads));
}

// An answer that names another function can be taken for none that is owed. It is owed for
// long enough not to be on the wire any more. Of the device's recent answer times only the last is
// surely one.
bool has_answered_since(const Lane& lane, const Flight& flight) {
  return lane.answered_at &&
         flight.begin >=
             *lane.answered_at + std::max<Duration>(kAdapterHolds, kAnswerTimes * lane.took);
}

// The first that is owed and may be what was answered is owed no more; nor is the next one, where
// the gateway may have forgotten the first. False: there is none.
template <typename Find, typename MayBe>
bool settle_first(Lane& lane, const Flight& asked, bool is_nobodys, Instant now, Find find,
                  MayBe may_be) {
  const auto settled = std::ranges::find_if(lane.owed, [&](std::uint64_t number) {
    const Flight* it = find(number);
    return it == nullptr || may_be(*it);
  });
  if (settled == lane.owed.end()) {
    return false;
  }
  // Whose answer it is that still comes while this one counts as owed.
  const auto real = [&](std::uint64_t number) {
    const Flight* it = find(number);
    return it != nullptr && it->owes_for != 0 ? it->owes_for : number;
  };
  const std::uint64_t unanswered = real(*settled);
  const auto own = std::ranges::find(lane.owed, asked.number, real);
  Flight* mine = own == lane.owed.end() ? nullptr : find(*own);
  // What is owed no more, as a second copy or later than the quarantine, settles what may still be
  // answered; what is owed leaves its place to that.
  const bool is_extra = is_nobodys || mine == nullptr;
  if (Flight* it = is_extra ? find(unanswered) : nullptr) {
    it->is_uncertain = true;
  }
  const Flight* it = find(*settled);
  const bool may_be_forgotten =
      it == nullptr || now >= it->deadline + spec::quarantine_of(it->timing);
  lane.owed.erase(settled);
  const bool settles_next =
      may_be_forgotten && settle_first(lane, asked, is_nobodys, now, find, may_be);
  if (!is_extra && !settles_next) {
    mine->owes_for = unanswered;
  }
  return true;
}

const char* excuse_of(const HeardFrame& frame, bool is_held) {
  if (frame.excuse != nullptr) {
    return frame.excuse;
  }
  return is_held ? "behind_adapter" : "beyond_quarantine";
}

}  // namespace

// Writes repeat their address and value, reads say how much they bring.
bool may_be_confused(const PduBytes& a, const PduBytes& b) {
  const auto same = [&](std::size_t from, std::size_t to) {
    return a.size() >= to && b.size() >= to &&
           std::equal(a.begin() + static_cast<std::ptrdiff_t>(from),
                      a.begin() + static_cast<std::ptrdiff_t>(to),
                      b.begin() + static_cast<std::ptrdiff_t>(from));
  };
  if (a.front() != b.front()) {
    return false;
  }
  switch (a.front()) {
    case 0x01:
    case 0x02:
    case 0x03:
    case 0x04:
    case 0x17: return same(3, 5);  // the quantity to read
    case 0x05:
    case 0x06:
    case 0x0F:
    case 0x10: return same(1, 5);
    case 0x16: return same(1, 7);
    default: return true;
  }
}

void Oracle::check_quarantine(const Flight& flight) {
  Lane& lane = books_[flight.bus].lanes[flight.address];
  // Each function has an end of its own: that of its last request.
  const auto holds = [&](std::uint64_t number, std::uint8_t function) {
    const Flight* owed = this->flight(number);
    return owed != nullptr && owed->pdu.front() == function &&
           schedule_.now() < owed->quarantine_until;
  };
  // Nothing is taken for an answer that comes later than any quarantine may last.
  const auto is_past = [&](const Flight& owed) {
    const Duration longest =
        std::max(owed.timing.quarantine_max, owed.quarantine_until - owed.deadline);
    return schedule_.now() > owed.deadline + longest;
  };
  std::erase_if(lane.owed, [&, before = lane.owed](std::uint64_t number) {
    const Flight* owed = this->flight(number);
    return owed == nullptr || is_past(*owed) || std::ranges::none_of(before, [&](auto other) {
             return holds(other, owed->pdu.front());
           });
  });
  const auto blocks = [&](std::uint64_t number) {
    const Flight* owed = this->flight(number);
    return owed != nullptr && schedule_.now() < owed->quarantine_until &&
           (owed->pdu.front() == flight.pdu.front() || !has_answered_since(lane, flight));
  };
  const auto blocking = std::ranges::find_if(lane.owed, blocks);
  if (blocking != lane.owed.end() && !flight.is_stop && !flight.repeats_read) {
    const Flight& owed = *this->flight(*blocking);
    const auto us = [&](Instant at) {
      return std::to_string((at - schedule_.now()) / std::chrono::microseconds(1)) + " us";
    };
    violation("quarantine", name(flight) + " while " + name(owed) + " is owed, sent " +
                                us(owed.begin) + ", due " + us(owed.deadline) + ", until " +
                                us(owed.quarantine_until));
  }
  if (flight.expects_answer) {
    lane.answered_at.reset();
    lane.owed.push_back(flight.number);
    if (lane.owed.size() > bus::kMostOwed) {
      lane.owed.pop_front();
    }
  }
}

// Nobody can tell which of several requests it answers: the quarantine counts from the last. One
// that does not fit what was asked ends no wait and settles no debt.
void Oracle::settle(std::size_t bus, const HeardFrame& frame) {
  note_uncertain(bus, frame);
  const Flight* from = flight(frame.flight);
  if (frame.flight == 0 || from == nullptr) {
    return;
  }
  const Flight& asked = *from;
  Book& book = books_[bus];
  Lane& lane = book.lanes[frame.address];
  const auto find = [this](std::uint64_t number) { return flight(number); };
  const auto settle = [&](const auto& may_be) {
    return settle_first(lane, asked, frame.is_nobodys, schedule_.now(), find, may_be);
  };
  if (frame.is_refused) {
    if (stands_for_echo(book) && is_for_last(book, frame) && !lane.answered_at) {
      lane.answered_at = schedule_.now();  // the echo stands for it then
      lane.took = Duration{0};
    }
    // If an earlier one is owed, it is that; else, where it stands for the echo, that is taken for
    // the answer.
    const bool is_earlier = settle([&](const Flight& it) {
      return it.number != book.last_flight && may_be_confused(it.pdu, asked.pdu);
    });
    if (!is_earlier && asked.number != book.last_flight && is_for_last(book, frame) &&
        stands_for_echo(book)) {
      std::erase(lane.owed, book.last_flight);
    }
    return;
  }
  if (!frame.fits) {
    // With another length it may be the answer to another request.
    settle([&](const Flight& it) {
      return it.number != asked.number && it.pdu.front() == asked.pdu.front();
    });
    return;
  }
  if (!lane.owed.empty() && flight(lane.owed.front()) != nullptr) {
    book.answered = book.last_flight;
  }
  if (!lane.answered_at) {
    lane.answered_at = schedule_.now();
    // Its time is one of the device's answer times if nothing ended the wait for it before.
    const bool is_in_time = book.last_flight == asked.number && frame.began < asked.deadline &&
                            book.open_stops.empty() && !frame.is_nobodys;
    lane.took = is_in_time ? std::max(frame.began - asked.end, Duration{0}) : Duration{0};
  }
  // It settles the oldest that it may be the answer to; those of another function stay owed.
  if (!settle([&](const Flight& it) { return may_be_confused(it.pdu, asked.pdu); })) {
    settle([&](const Flight& it) { return it.pdu.front() == asked.pdu.front(); });
  }
}

// A frame that begins after a later request was rightly transmitted may be taken for the answer to
// that: a second copy, or what a stranger asked for, if an adapter kept it, and what comes later
// than the quarantine in force. So may the true answer to such a request afterwards.
void Oracle::note_uncertain(std::size_t bus, const HeardFrame& frame) {
  Book& book = books_[bus];
  Flight* last = flight(book.last_flight);
  const bool is_its_own = last != nullptr && last->number == frame.flight && !frame.is_nobodys;
  if (last == nullptr || last->address != frame.address || is_its_own ||
      frame.began < last->begin) {
    return;
  }
  const Flight* from = flight(frame.flight);
  // An answer of another function than was asked for is one that nobody owes.
  const bool is_strange =
      !frame.fits && from != nullptr && mistaken(from->pdu.front()) == last->pdu.front();
  const bool is_held = frame.is_nobodys || is_strange || from == nullptr || from->is_uncertain;
  if (!is_held && last->begin < from->quarantine_until) {
    return;
  }
  last->is_uncertain = true;
  Lane& lane = book.lanes[frame.address];
  lane.boots_until = Instant::min();  // it may seem to have refused to
  lane.uncertain_at = schedule_.now();
  for (const std::uint64_t id : last->asked) {
    if (const auto entry = open_.find(id); entry != open_.end()) {
      entry->second->uncertain = excuse_of(frame, is_held);
    }
  }
  const bool is_ascii = bus_settings(bus).line.framing == bus::Framing::ascii;
  const bool looks_like_answer =
      is_strange && has_length_of_answer(frame.size, last->pdu, is_ascii);
  if ((frame.flight == 0 || looks_like_answer) && std::erase(lane.owed, last->number) > 0) {
    book.answered = last->number;
  }
}

bool Oracle::owes(std::size_t bus, std::uint8_t address) {
  const Book& book = books_[bus];
  const Flight* last = flight(book.last_flight);
  return !book.lanes[address].owed.empty() ||
         (last != nullptr && last->address == address && book.answered != last->number &&
          schedule_.now() < last->deadline);
}

}  // namespace mbgate::soak
