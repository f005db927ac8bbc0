// SPDX-License-Identifier: Apache-2.0
// The oracle's view of the wires: lines that come and go, what is transmitted, and what devices
// made of it.
#include <algorithm>
#include <iterator>
#include <utility>

#include "soak/boots.hpp"
#include "soak/identity.hpp"
#include "soak/oracle.hpp"
#include "soak/pdus.hpp"
#include "soak/word_orders.hpp"

namespace mbgate::soak {
namespace {

using namespace std::chrono_literals;
constexpr std::size_t kFlightsKept = 2000;
constexpr std::uint8_t kDeviceFailure = 0x04;

bool is_read(const PduBytes& pdu) { return (pdu[0] >= 1 && pdu[0] <= 4) || asks_identity(pdu); }

void note_done(Asked& asked, const PduBytes& pdu, Instant now) {
  for (Piece& piece : asked.pieces) {
    if (piece.pdu == pdu) {
      if (piece.asks_order && asked.other_order) {
        asked.device_exceptions.set(kDeviceFailure);
      }
      piece.done = {piece.executed ? piece.done.first : now, now};
      piece.executed = true;
    }
  }
}

// A broadcast is one for those whose form it has.
void note_written(Book& book, const Oracle::Devices& devices, const Flight& write, Instant now) {
  const auto has_form = [&](const Lane& lane) {
    const auto form = devices[*lane.device].settings().profile.broadcast.form;
    return (form == drive::BroadcastForm::autonics) == (write.address != 0);
  };
  for (std::size_t address = 0; address < book.lanes.size(); ++address) {
    Lane& lane = book.lanes.at(address);
    if (write.is_broadcast ? lane.device && has_form(lane) : address == write.address) {
      lane.written_at = now;
    }
  }
}

}  // namespace

std::string Oracle::name(const Flight& flight) const {
  return bus_settings(flight.bus).name + " address " + std::to_string(flight.address) + " pdu " +
         hex(flight.pdu);
}

void Oracle::bus_opened(std::size_t bus) {
  Book& book = books_[bus];
  book.open = true;
  book.starting = false;
  book.busy_since = schedule_.now();
  for (Asked* stop : std::exchange(book.early_stops, {})) {
    stop->waits_from = schedule_.now();
    book.stops.push_back(stop);
  }
  if (!std::exchange(book.rests, false)) {
    book.last_down = schedule_.now();  // until this moment
  }
  book.opening = false;
  book.in_vain.clear();
  check_told(book, bus);
  book.forget_line();
  WordOrders(*this).forget_line(bus);
  book.opened = schedule_.now();
  book.is_restarted = false;
  ++book.openings;
  if (std::exchange(book.is_first, false) && before_restart_ > 0) {
    book.listens_until = book.opened + listens_for(bus);
  }
  book.is_unused = true;
  book.last_byte = schedule_.now();
  book.own_end = std::min(book.own_end, schedule_.now());  // the rest of a frame was lost with it
  for (Lane& lane : book.lanes) {
    lane.forget_silence();  // what its device owes it still owes
    lane.emptied_at = lane.emptied_for = book.opened;
  }
}

// By default as long as the longest ordinary answer may take.
Duration Oracle::listens_for(std::size_t bus) const {
  Duration longest{0};
  for (const SoakDevice& device : devices_) {
    const drive::DeviceTiming& timing = device.settings().timing;
    if (static_cast<std::size_t>(device.settings().bus) == bus) {
      longest = std::max(longest, timing.response_timeout + spec::quarantine_of(timing));
    }
  }
  return bus_settings(bus).listen_first.value_or(longest);
}

Past Oracle::take_past() {
  Past past{std::move(flights_), flight_count_, ids_, {}};
  std::ranges::transform(books_, std::back_inserter(past.openings), &Book::openings);
  return past;
}

void Oracle::begin_with(Past past) {
  flights_ = std::move(past.flights);
  flight_count_ = before_restart_ = past.flight_count;
  ids_ = past.ids;
  for (std::size_t bus = 0; bus < books_.size(); ++bus) {
    books_[bus].openings = past.openings[bus];
  }
}

void Oracle::bus_opening(std::size_t bus) {
  books_[bus].opening = true;
  check_reopening(bus);
}

void Oracle::bus_lost(std::size_t bus) {
  Book& book = books_[bus];
  note_loss(bus);
  note_interrupted(book);
  book.open = book.starting = book.rests = book.opening = book.is_restarted = false;
  book.early_stops.clear();
  book.last_down = schedule_.now();
  book.stops.clear();
  book.flying.clear();
  book.unheard.clear();
  book.forget_boots();
}

Flight* Oracle::flight(std::uint64_t number) const {
  if (flights_.empty() || number < flights_.front()->number) {
    return nullptr;
  }
  return flights_[static_cast<std::size_t>(number - flights_.front()->number)].get();
}

Flight& Oracle::transmitted(std::size_t bus, Bytes frame) {
  ++report_.transmissions;
  Flight& flight = *flights_.emplace_back(std::make_unique<Flight>());
  flight.number = ++flight_count_;
  flight.bus = bus;
  flight.begin = schedule_.now();
  if (flights_.size() > kFlightsKept) {
    flights_.pop_front();
  }
  Book& book = books_[bus];
  note_silent(bus);
  WordOrders(*this).after_wait(bus);
  const Flight* before = this->flight(book.last_flight);
  book.last_flight = flight.number;
  if (!book.open) {
    violation("closed_line", "transmission on " + bus_settings(bus).name);
  }
  if (!take_apart(frame, flight)) {
    violation("malformed_frame", hex(frame));
    return flight;
  }
  flight.end = flight.begin;
  if (!is_tcp(bus)) {
    const auto& line = bus_settings(bus).line;
    flight.end += spec::WireTimes(line).of(frame.size());
  }
  flight.is_write = !is_read(flight.pdu);
  flight.is_broadcast = !is_tcp(bus) && is_for_all(plan_, bus, flight.address);
  cut_flying(book);
  attribute(flight);
  WordOrders(*this).note_told(flight);
  check_stops_first(flight);
  note_stops(flight);
  is_tcp(bus) ? check_tcp(flight) : check_silence(flight);
  check_bounds(flight, before);
  BootRules(*this).take(flight);
  set_times(flight);
  note_use(flight);
  flight.size = frame.size();
  book.is_unused = false;
  book.came = book.read = book.before_pause = 0;
  book.tail = {};
  book.heard.clear();
  book.denied_before = std::exchange(book.denied_echo, false);
  book.read_while_sending = Instant::min();
  book.is_strange = false;
  note_counts(flight);
  if (is_tcp(bus) && flight.expects_answer) {
    book.in_vain.push_back(flight.number);
  }
  if (!is_tcp(bus)) {
    note_debt(flight);
    book.own_end = book.busy_since = flight.end;
    if (flight.is_broadcast) {
      book.turnaround_end = flight.end + bus_settings(bus).turnaround;
    }
  }
  return flight;
}

bool Oracle::take_apart(Bytes frame, Flight& flight) {
  if (is_tcp(flight.bus)) {
    if (frame.size() < 8 || spec::word_at(frame, 2) != 0 ||
        spec::word_at(frame, 4) != frame.size() - 6) {
      return false;
    }
    flight.identifier = spec::word_at(frame, 0);
    flight.address = frame[6];
    flight.pdu.assign(frame.begin() + 7, frame.end());
    return true;
  }
  const auto adu = bus_settings(flight.bus).line.framing == bus::Framing::ascii
                       ? spec::read_ascii(frame)
                       : spec::read_rtu(frame);
  if (adu) {
    flight.address = adu->address;
    flight.pdu = adu->pdu;
  }
  return adu.has_value();
}

void Oracle::executed(const Flight& flight) {
  note_done_for_failsafe(flight);
  Lane& lane = books_[flight.bus].lanes[flight.address];
  lane.knows_order = lane.knows_order || flight.asks_order;
  if (flight.is_stop) {
    lane.stops_done[flight.pdu] = schedule_.now();
  } else if (flight.is_write) {
    note_written(books_[flight.bus], devices_, flight, schedule_.now());
  }
  for (const std::uint64_t id : flight.asked) {
    if (const auto entry = open_.find(id); entry != open_.end()) {
      note_done(*entry->second, flight.pdu, schedule_.now());
    }
  }
}

// Where the settings do not say that there is one, the answer behind it may be taken.
void Oracle::echo_spoilt(const Flight& flight) {
  if (!bus_settings(flight.bus).line.echo.value_or(false)) {
    return;
  }
  ++books_[flight.bus].count.spoilt_echoes;
  for (const std::uint64_t id : flight.asked) {
    if (const auto entry = open_.find(id); entry != open_.end()) {
      ++entry->second->spoilt;
    }
  }
}

void Oracle::excepted(const Flight& flight, std::uint8_t code) {
  if (Flight* refused = this->flight(flight.number)) {
    refused->refused = code;
  }
  for (const std::uint64_t id : flight.asked) {
    if (const auto entry = open_.find(id); entry != open_.end()) {
      entry->second->device_exceptions.set(code);
      for (const Piece& piece : entry->second->pieces) {
        if (piece.asks_order && piece.pdu == flight.pdu) {
          entry->second->device_exceptions.set(kDeviceFailure);  // it did not say the right one
        }
      }
    }
  }
}

}  // namespace mbgate::soak
