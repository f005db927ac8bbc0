// SPDX-License-Identifier: Apache-2.0
// What the oracle asks of stops: before all else, soon, and even on a line that is never silent;
// and whose turn it may be while something is repeated.
#include <algorithm>
#include <map>

#include "soak/identity.hpp"
#include "soak/oracle.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

namespace {

/// So many bytes of the answer may seem to be missing once one was read; of some, once damaged, any
/// number.
std::size_t most_missing(const PduBytes& pdu) {
  const auto fields = spec::fields_of(pdu);
  if (pdu.empty() || asks_identity(pdu) || spec::is_opaque(pdu) || !fields) {
    return spec::kRtuFrame;
  }
  constexpr std::size_t kBeside = 5;  // address, function, byte count and CRC
  return fields->reads ? kBeside + spec::data_size_of(*fields->reads) : pdu.size() + kBeside;
}

/// Behind a stop that perhaps nobody answered a request may have its turn, if one waits.
bool may_give_way(const Book& book, const Flight* last) {
  const auto waits = [](const Asked* asked) { return !asked->is_stop(); };
  return last != nullptr && last->is_stop && last->expects_answer && !last->is_answered &&
         std::ranges::any_of(
             book.lanes, [&](const Lane& lane) { return std::ranges::any_of(lane.open, waits); });
}

}  // namespace

// With `stop_cancels = false` the writes that were accepted before it go first.
bool Oracle::lets_writes_go(const Asked& stop) const {
  return !stop.stops_all && !devices_[*stop.door->device].settings().stop_cancels;
}

// Between two stops to a silent device one transaction of another goes. Whether its answer could be
// read is not asked here. Among stops who came first goes first.
void Oracle::check_stops_first(const Flight& flight) {
  const auto is_repeated = [&](std::uint64_t id) {
    const auto entry = open_.find(id);
    return entry != open_.end() && entry->second->flights > 1;
  };
  const bool is_unclear =
      flight.is_stop && (!flight.stop_from || std::ranges::any_of(flight.asked, is_repeated));
  if (is_tcp(flight.bus) || is_unclear) {
    return;
  }
  const Book& book = books_[flight.bus];
  const Instant before = flight.is_stop ? *flight.stop_from : schedule_.now();
  for (const Asked* stop : book.stops) {
    const std::uint8_t address = stop->pieces.front().address;
    const bool repeats = book.lanes[address].may_repeat_stop(flight.begin);
    const bool gives_way =
        repeats || (!stop->stops_all && (flight.is_stop || address != flight.address) &&
                    book.lanes[address].stop_sent > book.last_other);
    const bool may_be_behind = flight.is_stop && (stop->stops_all || stop->pieces.front().sent > 0);
    if (stop->accepted < before && !lets_writes_go(*stop) && is_surely_open(*stop) && !gives_way &&
        !may_be_behind) {
      violation("stop_overtaken", name(*stop) + " by " + name(flight));
      return;
    }
  }
}

void Oracle::note_stops(Flight& flight) {
  Book& book = books_[flight.bus];
  // Identical ones may wait apart: a write stood between them, or one of them was tried before.
  const bool is_for_one = std::ranges::any_of(book.open_stops, [&](const Asked* stop) {
    return std::ranges::find(flight.asked, stop->id) != flight.asked.end();
  });
  flight.beside_stop = book.open_stops.size() > (is_for_one ? 1U : 0U);
  Lane& lane = book.lanes[flight.address];
  if (!flight.is_stop) {
    book.last_other = flight.number;
    return;
  }
  lane.stop_sent_at = flight.begin;
  lane.stop_sent = flight.expects_answer ? flight.number : lane.stop_sent;
}

Duration Oracle::stop_deadline(std::size_t bus) const {
  return spec::stop_deadline_of(bus_settings(bus));
}

// A stop that found no silence for so long is sent all the same, once.
bool Oracle::may_break_silence(const Flight& flight) {
  const Instant from =
      flight.is_failsafe ? Instant::min() : flight.stop_from.value_or(flight.begin);
  return flight.begin >= std::max(from, books_[flight.bus].busy_since) + stop_deadline(flight.bus);
}

// A stop that waits goes when what runs has ended, or was cut at `stop_wait`; at its deadline in
// any case.
void Oracle::check_stops_waiting(std::size_t bus) {
  const Book& book = books_[bus];
  if (book.stops.empty() || is_tcp(bus) || finished_) {
    return;
  }
  const Instant now = schedule_.now();
  const auto& settings = bus_settings(bus);
  const spec::WireTimes times(settings.line);
  const Duration silence = spec::silence_of(settings);
  // What may hold a stop back: an own frame, a response that has begun, the turnaround delay.
  const Flight* last = flight(book.last_flight);
  const std::size_t missing = last != nullptr ? most_missing(last->pdu) : 0;
  const Duration rest = settings.line.framing == bus::Framing::ascii
                            ? 1s
                            : spec::slack_of(settings) + times.of(missing);
  const Instant held = std::max({book.own_end, book.turnaround_end, book.held_until});
  for (Asked* stop : book.stops) {
    const Lane& lane = book.lanes[stop->pieces.front().address];
    // To a device that was given up, or once more: nothing that runs is cut.
    const bool repeats = last != nullptr && lane.may_repeat_stop(now);
    const bool is_patient = repeats || (!stop->stops_all && lane.stop_sent != 0 &&
                                        is_past_offline(bus, lane) && last != nullptr);
    // From the end of the last try on that turn has so long to begin.
    const Duration turn =
        repeats || may_give_way(book, last) ? settings.stop_wait + lateness() : Duration{0};
    const Instant from = std::max({held, *stop->waits_from, book.stop_wait_from,
                                   is_patient ? last->due + rest : Instant::min()});
    const Instant limit =
        std::max(from, book.last_handed_in + rest) + settings.stop_wait + silence + 1us + turn;
    const Instant deadline = std::max({from, book.busy_since, book.touched}) + stop_deadline(bus) +
                             settings.stop_wait + rest + times.of(spec::kRtuFrame);
    const bool is_overdue = now > deadline && now <= book.last_handed_in + silence;
    if ((now > limit || is_overdue) && !stop->overdue_reported && !lets_writes_go(*stop) &&
        is_surely_open(*stop)) {
      stop->overdue_reported = true;
      violation(is_overdue ? "stop_deadline" : "stop_late", name(*stop));
    }
  }
}

}  // namespace mbgate::soak
