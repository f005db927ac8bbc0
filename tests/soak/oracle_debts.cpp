// SPDX-License-Identifier: Apache-2.0
// What devices owe: for how long nothing else may be sent to them at the least, and which answer
// came, or may have come, in place of another.
//
// A frame that begins after a later request was rightly transmitted may be taken for the answer to
// that. Physics gives no certainty then: the run counts what comes of it apart (oracle_slips.cpp).
#include <algorithm>

#include "soak/oracle.hpp"

namespace mbgate::soak {
namespace {

constexpr std::size_t kSentKept = 64;
constexpr Duration kSecondsSlack = std::chrono::milliseconds(20);  // of what was learned

// A quarter more than what was shown.
Duration and_a_quarter(Duration shown) { return shown + shown / 4; }

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

void Oracle::note_debt(const Flight& flight) {
  Lane& lane = books_[flight.bus].lanes[flight.address];
  if (flight.expects_answer) {
    lane.sent.push_back(flight.number);
    if (lane.sent.size() > kSentKept) {
      lane.sent.pop_front();
    }
  }
}

// Nothing else that was sent to its device may seem to be owed: each was paid before the next one
// was sent, and nobody has slipped for as long.
bool Oracle::is_only_debt(const Lane& lane, const HeardFrame& frame) const {
  const Flight* from = flight(frame.flight);
  if (from == nullptr || frame.is_nobodys || has_second(lane)) {
    return false;
  }
  const Instant since = schedule_.now() - owed_for(*from);
  return lane.uncertain_at < since && std::ranges::all_of(lane.sent, [&](std::uint64_t number) {
           const Flight* it = flight(number);
           return it == nullptr || number == frame.flight || it->begin < since || it->is_answered;
         });
}

// For so long at most something is owed.
Duration Oracle::owed_for(const Flight& flight) {
  return std::max<Duration>(flight.timing.quarantine_max, flight.quarantine_until - flight.begin) +
         flight.timing.quarantine_max;
}

bool Oracle::has_second(const Lane& lane) const {
  return lane.device && plan_.ways[*lane.device].second > 0;
}

// A good frame has come: whose it is, and whose it may have been taken for.
void Oracle::settle(std::size_t bus, const HeardFrame& frame) {
  Lane& lane = books_[bus].lanes[frame.address];
  note_uncertain(bus, frame);
  const bool is_first = frame.flight != 0 && !frame.is_nobodys;
  for (const std::uint64_t number : lane.sent) {
    Flight* sent = flight(number);
    if (sent != nullptr && (!frame.fits || is_first || frame.is_second)) {
      sent->may_be_paid = true;  // by whatever names its function, or a misfit
    }
  }
  Flight* from = flight(frame.flight);
  if (from == nullptr || frame.is_nobodys) {
    note_second(lane, frame, from);
    return;
  }
  if (!frame.fits) {
    return;
  }
  from->paid_at = from->paid_at.value_or(frame.began);
  if (from->refused && !from->refused_at) {
    from->refused_at = schedule_.now();
  }
  lane.clean = std::min(lane.clean + 1, kCleanForgets);
  lane.shown = std::max(shown(lane), frame.began - from->end);
  lane.shown_at = schedule_.now();
}

void Oracle::note_second(Lane& lane, const HeardFrame& frame, const Flight* from) {
  if (!frame.is_second || from == nullptr || !from->paid_at) {
    return;
  }
  lane.second_shown = std::max(lane.clean < kCleanForgets ? lane.second_shown : Duration{0},
                               frame.began - *from->paid_at);
  lane.clean = 0;
}

// What was learned fades by an eighth a minute.
Duration Oracle::shown(const Lane& lane) const {
  Duration shown = lane.shown;
  for (Instant at = lane.shown_at + std::chrono::minutes(1);
       at <= schedule_.now() && shown > Duration{0}; at += std::chrono::minutes(1)) {
    shown -= shown / 8;
    shown = shown < std::chrono::microseconds(1) ? Duration{0} : shown;
  }
  return shown;
}

// Why nobody could know that it is not the answer to what was sent last. What follows from an
// earlier slip is none of these.
const char* Oracle::root_of(const Lane& lane, const HeardFrame& frame, const Flight* from,
                            bool is_strange) const {
  if (frame.flight == 0) {
    return kStrangers;
  }
  if (frame.is_second && from != nullptr && from->paid_at) {
    const Duration after = frame.began - *from->paid_at;
    const bool is_known = lane.clean < kCleanForgets && after <= from->due - from->end &&
                          after <= and_a_quarter(lane.second_shown) + kSecondsSlack;
    return is_known ? nullptr : "second_answer";
  }
  if (frame.is_nobodys || is_strange) {
    return "behind_adapter";
  }
  if (from == nullptr || from->number <= before_restart_) {
    return from == nullptr ? "long_ago" : "before_restart";
  }
  return frame.began - from->end > and_a_quarter(shown(lane)) ? "later_than_ever" : nullptr;
}

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
  const bool was_listened_for = from != nullptr && from->number <= before_restart_ &&
                                !last->is_stop && frame.began < book.listens_until;
  if (!is_held && (last->begin < from->quarantine_until || was_listened_for)) {
    return;
  }
  Lane& lane = book.lanes[frame.address];
  const char* root =
      frame.excuse != nullptr ? frame.excuse : root_of(lane, frame, from, is_strange);
  last->is_uncertain = true;
  lane.boots_until = Instant::min();  // it may seem to have refused to
  lane.uncertain_at = schedule_.now();
  lane.slips.caused = root != nullptr ? schedule_.now() : lane.slips.caused;
  for (const std::uint64_t id : last->asked) {
    if (const auto entry = open_.find(id); entry != open_.end()) {
      entry->second->uncertain = root != nullptr ? root : "slipped";
    }
  }
}

bool Oracle::owes(std::size_t bus, std::uint8_t address) {
  const Book& book = books_[bus];
  const Flight* last = flight(book.last_flight);
  const auto is_owed = [&](std::uint64_t number) {
    const Flight* it = flight(number);
    return it != nullptr && !it->paid_at && schedule_.now() < it->quarantine_until;
  };
  return std::ranges::any_of(book.lanes[address].sent, is_owed) ||
         (last != nullptr && last->address == address && !last->paid_at &&
          schedule_.now() < last->deadline);
}

}  // namespace mbgate::soak
