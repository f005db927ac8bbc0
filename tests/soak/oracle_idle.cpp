// SPDX-License-Identifier: Apache-2.0
// Nothing is needlessly late on a serial line: what may go goes as soon as the wire is silent. Only
// what nothing from outside this line can hold back is judged.
#include <algorithm>

#include "soak/behind_stops.hpp"
#include "soak/heard_answers.hpp"
#include "soak/oracle.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

namespace {

constexpr Duration kLongestLate = 20ms;
constexpr Duration kLongestStall = 520ms;
constexpr Duration kStop = 1520ms;
constexpr Duration kTimeToClose = 50ms;  // for a server that closes after each answer

// The wire may be kept free for who has waited for its device's gap before, and then expires.
Duration longest_gap(const Oracle::Devices& devices, const SoakPlan& plan, std::size_t bus) {
  Duration longest = plan.settings.buses[bus].timing.gap;
  for (const SoakDevice& device : devices) {
    if (static_cast<std::size_t>(device.settings().bus) == bus) {
      longest = std::max(longest, device.settings().timing.gap);
    }
  }
  return longest;
}

}  // namespace

// The process may come so late to what is due.
Duration Oracle::lateness() const {
  const DriverManners& driver = plan_.driver;
  return 1ms + driver.usual + (driver.late > 0 ? kLongestLate : 0ms) +
         (driver.slow > 0 ? kLongestLate : 0ms) +
         (driver.stops    ? kStop
          : driver.stalls ? kLongestStall
                          : 0ms);
}

void Oracle::note_whole(std::size_t bus, HeardFrame& frame) const {
  const Book& book = books_[bus];
  const auto& owed = book.lanes[frame.address].owed;
  frame.ended = schedule_.now();
  frame.came = book.came;
  // Each try of a stop does the same, and by 06 its echo shows which stop that was.
  const Flight* last = flight(book.last_flight);
  const auto is_try_of_last = [&](std::uint64_t number) {
    const Flight* it = flight(number);
    return it != nullptr && it->asked.size() == 1 && it->asked == last->asked;
  };
  frame.is_only_debt = (owed.size() == 1 && owed.front() == frame.flight) ||
                       (last != nullptr && last->is_stop && last->pdu.front() == 0x06 &&
                        std::ranges::all_of(owed, is_try_of_last));
  const Flight* from = flight(frame.flight);
  frame.is_late = from != nullptr && std::ranges::count(owed, frame.flight) > 0 &&
                  std::ranges::all_of(owed, [&](std::uint64_t number) {
                    const Flight* it = flight(number);
                    const bool may_wait = it != nullptr && it->number == book.last_flight;
                    return it != nullptr && it->pdu == from->pdu &&
                           frame.began >= it->due + (may_wait ? lateness() : Duration{0});
                  });
}

// How long an answer may take from its first byte on.
Duration Oracle::rest_of_answer(const Flight& flight) const {
  const auto& settings = bus_settings(flight.bus);
  return settings.line.framing == bus::Framing::ascii
             ? spec::WireTimes(settings.line).of(spec::kAsciiFrame) + 1s
             : spec::WireTimes(settings.line).of(spec::kRtuFrame) + spec::slack_of(settings) + 20ms;
}

// The answer to what was transmitted last.
void Oracle::note_answered(std::size_t bus, const HeardFrame& frame) {
  Book& book = books_[bus];
  Flight* last = flight(book.last_flight);
  if (last == nullptr || last->number != frame.flight || !frame.fits || frame.is_nobodys) {
    return;
  }
  last->unsure = HeardAnswers(*this).why_unsure(*last, frame);
  if (last->unsure == nullptr || last->unsure == kBesideStop) {
    book.use.fitting = schedule_.now();
    book.use.is_behind_noise =
        frame.lead > 0 && bus_settings(bus).line.framing == bus::Framing::rtu;
  }
  if (last->unsure != nullptr) {
    return;
  }
  last->is_answered = true;
  last->needs_silence = frame.lead > 0;
  if (!last->needs_silence) {
    book.use.is_answered = true;
    book.use.ends = schedule_.now();
  }
  // By a quarantine that has grown an earlier one is still owed: then this may be the answer to it.
  if (Lane& lane = book.lanes[frame.address]; lane.held_before <= last->begin) {
    lane.held_until = lane.held_before;
    lane.holds.note_paid(lane.held_before);
  }
}

void Oracle::note_use(const Flight& flight) {
  Book& book = books_[flight.bus];
  if (is_tcp(flight.bus)) {
    if (!flight.expects_answer) {  // its drive boots then
      book.lanes[flight.address].held_until = flight.due + kLongestBoot + lateness();
    }
    return;
  }
  const Duration turnaround = bus_settings(flight.bus).turnaround;
  book.use.first_read = Instant::min();
  book.use.is_answered = flight.is_broadcast;
  book.use.ends = flight.is_broadcast ? flight.end
                                      : std::max(flight.due, flight.end + turnaround) +
                                            bus_settings(flight.bus).settle;
  Lane& lane = book.lanes[flight.address];
  lane.held_before = lane.held_until;
  // What is never answered may seem to be, by a damaged frame; then the device is held back too.
  const Duration quarantine =
      std::max({spec::quarantine_of(flight.timing), flight.timing.quarantine_max, kLongestBoot});
  const Duration held =
      flight.is_broadcast ? kLongestBoot : quarantine + kAdapterHolds + lateness();
  const Instant until = book.use.ends + held + rest_of_answer(flight);
  lane.held_until = std::max(lane.held_until, until);
  lane.holds.note_sent(flight.pdu.front(), flight.begin, until);
  if (flight.is_stop) {
    book.use.waits_from = book.use.ends;
  }
  if (flight.is_broadcast) {
    book.use.waits_from = flight.end + turnaround + kLongestBoot;
  }
}

// From when on nothing held it back; none if nobody can tell.
std::optional<Instant> Oracle::could_go(const Flight& flight) const {
  const Book& book = books_[flight.bus];
  const Lane& lane = book.lanes[flight.address];
  if (flight.is_broadcast || flight.is_stop || flight.asked.empty() || !book.has_only_usual() ||
      is_past_offline(flight.bus, lane)) {
    return std::nullopt;
  }
  Instant from = std::max(reloaded_, book.use.waits_from);
  for (const std::uint64_t id : flight.asked) {
    const auto entry = open_.find(id);
    if (entry == open_.end()) {
      return std::nullopt;
    }
    const Asked& asked = *entry->second;
    if (asked.ordered || asked.ahead || asked.dropped) {
      return std::nullopt;
    }
    from = std::max({from, asked.accepted, asked.waited_until});
  }
  const Instant held = lane.holds.until(flight.pdu.front(), lane.held_until);
  return flight.surely_repeats ? from : std::max(from, held);
}

// What finds a place goes at once.
void Oracle::check_idle_connection(const Flight& flight) {
  Book& book = books_[flight.bus];
  const auto& settings = bus_settings(flight.bus);
  const Instant heard = book.last_handed_in + (book.use.closes ? kTimeToClose : 0ms);
  const Instant free = std::max({book.use.ends, book.opened, heard}) + settings.settle +
                       longest_gap(devices_, plan_, flight.bus);
  book.use.ends = std::max(book.use.ends, flight.begin);
  if (flight.begin < book.touched + 1s) {
    return;
  }
  const Duration most = 2 * lateness();  // to note that one is over, and to transmit the next
  TurnRules(*this).check_idle(flight, free, most);
  const auto from = could_go(flight);
  if (from && flight.begin - std::max(free, *from) > most &&
      !TurnRules(*this).is_in_use(flight.address, flight)) {
    violation("idle_connection", name(flight) + " " +
                                     std::to_string((flight.begin - std::max(free, *from)) / 1us) +
                                     " us late");
  }
}

void Oracle::check_idle(const Flight& flight, const Flight* before) {
  if (is_tcp(flight.bus)) {
    return check_idle_connection(flight);
  }
  const Book& book = books_[flight.bus];
  const auto from = could_go(flight);
  const auto& settings = bus_settings(flight.bus);
  const Duration gap = longest_gap(devices_, plan_, flight.bus);
  const Duration silence = spec::silence_of(settings) + gap;
  // Until then an answer may have been on its way.
  Instant ends = book.use.ends;
  Instant read = book.last_handed_in;
  if (before != nullptr && !book.use.is_answered && is_damaged_answer(plan_, book, *before)) {
    ends = book.last_handed_in + std::max(spec::slack_of(settings), silence) + settings.settle;
  } else if (const auto until =
                 before == nullptr ? std::nullopt : HeardAnswers(*this).stuck_until(*before)) {
    ends = *until + settings.settle;
  } else if (!book.use.is_answered && book.came > 0) {
    read = std::max(ends, read) + rest_of_answer(flight);
  }
  const Instant free = std::max({book.own_end, book.turnaround_end, book.held_until,
                                 book.opened + settings.listen_first.value_or(1s), read, ends}) +
                       silence;
  BehindStops(*this).note_held(flight, free - gap);
  // Until lately other settings may have asked for other pauses.
  if (flight.begin < std::max(book.opened, book.touched + 1s)) {
    return;
  }
  const Duration most = lateness() * (book.use.is_answered ? 1 : 2);
  TurnRules(*this).check_idle(flight, free, most);
  const Duration late = from ? flight.begin - std::max(free, *from) : Duration{0};
  if (late > most) {
    violation("idle_wire", name(flight) + " " + std::to_string(late / 1us) + " us late");
  }
}

}  // namespace mbgate::soak
