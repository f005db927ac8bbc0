// SPDX-License-Identifier: Apache-2.0
// The oracle's view of the wires: which request a transmission is for, and whether it may begin
// now.
#include <algorithm>

#include "modbus/ascii.hpp"
#include "modbus/rtu.hpp"
#include "soak/oracle.hpp"

namespace mbgate::soak {
namespace {

using namespace std::chrono_literals;
constexpr std::size_t kFlightsKept = 2000;

bool is_read_function(std::uint8_t function) {
  return (function >= 1 && function <= 4) || function == 0x11 || function == 0x2B;
}

}  // namespace

std::string Oracle::hex(Bytes bytes) {
  constexpr char kDigits[] = "0123456789ABCDEF";
  std::string text;
  for (const std::uint8_t byte : bytes) {
    text += {kDigits[byte >> 4U], kDigits[byte & 15U]};
  }
  return text;
}

std::string Oracle::name(const Flight& flight) const {
  return bus_settings(flight.bus).name + " address " + std::to_string(flight.address) + " pdu " +
         hex(flight.pdu);
}

void Oracle::bus_opened(std::size_t bus) {
  Book& book = books_[bus];
  book.open = true;
  book.starting = false;
  for (Asked* stop : std::exchange(book.early_stops, {})) {
    stop->waits_from = schedule_.now();
    book.stops.push_back(stop);
  }
  if (!std::exchange(book.rests, false)) {
    book.last_down = schedule_.now();  // until this moment
  }
  book.opening = false;
  book.in_vain.clear();
  failsafe_line_back(book);
  book.last_byte = schedule_.now();
  book.own_end = std::min(book.own_end, schedule_.now());  // the rest of a frame was lost with it
  for (Lane& lane : book.lanes) {
    lane.owed.clear();
  }
}

void Oracle::bus_lost(std::size_t bus) {
  Book& book = books_[bus];
  note_interrupted(book);
  book.open = book.starting = book.rests = book.opening = false;
  book.early_stops.clear();
  book.last_down = schedule_.now();
  book.stops.clear();
  book.flying.clear();
  book.unheard.clear();
}

Flight* Oracle::flight(std::uint64_t number) {
  if (flights_.empty() || number < flights_.front().number) {
    return nullptr;
  }
  return &flights_[number - flights_.front().number];
}

Flight& Oracle::transmitted(std::size_t bus, Bytes frame) {
  ++report_.transmissions;
  Flight& flight = flights_.emplace_back();
  flight.number = ++flight_count_;
  flight.bus = bus;
  flight.begin = schedule_.now();
  if (flights_.size() > kFlightsKept) {
    flights_.pop_front();
  }
  begin_failsafe();
  Book& book = books_[bus];
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
    flight.end += modbus::RtuTiming(line.baud, line.format).duration_of(frame.size());
  }
  flight.is_write = !is_read_function(flight.pdu.front());
  flight.is_broadcast = flight.address == 0 && !is_tcp(bus);
  cut_flying(book);
  attribute(flight);
  check_stops_first(flight);
  note_stops(flight);
  is_tcp(bus) ? check_tcp(flight) : check_silence(flight);
  set_times(flight);
  note_counts(flight);
  if (is_tcp(bus) && flight.expects_answer) {
    book.in_vain.push_back(flight.number);
  }
  if (!is_tcp(bus)) {
    check_quarantine(flight);
    book.own_end = book.busy_since = flight.end;
    if (flight.is_broadcast) {
      book.turnaround_end = flight.end + bus_settings(bus).turnaround;
    }
  }
  return flight;
}

bool Oracle::take_apart(Bytes frame, Flight& flight) {
  if (is_tcp(flight.bus)) {
    if (frame.size() < 8 || modbus::load_be16(frame, 2) != 0 ||
        modbus::load_be16(frame, 4) != frame.size() - 6) {
      return false;
    }
    flight.identifier = modbus::load_be16(frame, 0);
    flight.address = frame[6];
    flight.pdu.assign(frame.begin() + 7, frame.end());
    return true;
  }
  const auto adu = bus_settings(flight.bus).line.framing == bus::Framing::ascii
                       ? modbus::decode_ascii(frame)
                       : modbus::decode_rtu(frame);
  if (adu) {
    flight.address = adu->address;
    flight.pdu.assign(adu->pdu.bytes().begin(), adu->pdu.bytes().end());
  }
  return adu.has_value();
}

bool Oracle::fits(const Asked& asked, const Piece& piece, const Flight& flight) const {
  if (piece.pdu == flight.pdu) {
    return true;
  }
  const bool may_merge = bus_settings(flight.bus).merge ||
                         (asked.is_accepted && asked.accepted <= books_[flight.bus].last_merge);
  if (!may_merge || !asked.is_read() || asked.pieces.size() > 1 ||
      piece.pdu.front() != flight.pdu.front() || flight.pdu.size() != 5) {
    return false;
  }
  const unsigned first = modbus::load_be16(piece.pdu, 1);
  const unsigned merged = modbus::load_be16(flight.pdu, 1);
  return first >= merged &&
         first + modbus::load_be16(piece.pdu, 3) <= merged + modbus::load_be16(flight.pdu, 3);
}

// Why the piece may not be transmitted now; nothing if it may.
std::string Oracle::objection(const Asked& asked, const Piece& piece) const {
  const Instant now = schedule_.now();
  const drive::DeviceTiming timing =
      asked.door->device ? devices_[*asked.door->device].settings().timing : drive::DeviceTiming{};
  if (piece.taken_back) {
    return "other_meaning";
  }
  if (asked.is_stop()) {
    const bool is_shared = (modbus::load_be16(piece.pdu, 3) & 0xFFFU) == 0xFFFU;
    const bool repeated = !asked.stops_all && piece.pdu[2] == (kStopRegister & 0xFFU);
    const unsigned repeats = repeated ? std::max(asked.stop_retries, timing.stop_retries) : 0;
    if (asked.failsafe) {
      return piece.sent >= (1 + repeats) * failsafes_like(asked, piece) ? "failsafe_too_often" : "";
    }
    return asked.surely_on_wire && !is_shared && piece.sent > repeats ? "stop_too_often" : "";
  }
  if (!asked.is_accepted) {
    return "pipeline";
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
  if (asked.changes() && piece.sent > (once ? 0 : asked.retries)) {
    return "write_twice";
  }
  return "";
}

// Takes the requests that the frame may be for and speaks against none of them.
void Oracle::attribute(Flight& flight) {
  const Lane& lane = books_[flight.bus].lanes[flight.address];
  std::vector<std::pair<Asked*, Piece*>> meant;
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
  } else if (meant.empty()) {
    unknown_transmission(flight);
  }
  for (const auto& [asked, piece] : meant) {
    flight.asked.push_back(asked->id);
    note_sent(*asked, *piece, flight, meant.size() == 1);
  }
}

void Oracle::unknown_transmission(const Flight& flight) {
  for (auto done = done_.rbegin(); done != done_.rend(); ++done) {
    if (done->bus == flight.bus && done->address == flight.address && done->pdu == flight.pdu) {
      violation(done->how, name(flight));
      return;
    }
  }
  violation("unknown_transmission", name(flight));
}

void Oracle::note_sent(Asked& asked, Piece& piece, const Flight& flight, bool alone) {
  Flight& mine = const_cast<Flight&>(flight);
  mine.is_stop = mine.is_stop || asked.is_stop();
  mine.expects_answer = mine.expects_answer && !asked.silent && asked.kind != Kind::broadcast;
  if (alone && !asked.maybe_on_wire && !asked.is_stop()) {
    check_order(asked, flight);
    if (const std::string owner = writers_.sent(asked, schedule_.now()); !owner.empty()) {
      violation("writer", name(asked) + ", but " + owner);
    }
  }
  mine.repeats_read = mine.repeats_read || (asked.is_read() && asked.last_sent == flight.pdu);
  mine.is_part = mine.is_part || (asked.pieces.size() > 1 && asked.kind != Kind::broadcast);
  if (alone && mine.repeats_read && asked.last_alone != 0 && !mine.is_part && !is_tcp(flight.bus)) {
    check_turns(asked, flight);
  }
  asked.last_alone = alone ? flight.number : 0;
  asked.last_sent = flight.pdu;
  if (asked.failsafe && asked.flights == 0 && books_[piece.bus].last_down >= asked.accepted) {
    report_.fault("failsafe_sent_later");
  }
  ++asked.flights;
  // What has become due in this instant joins one that is due already, or goes on its own.
  const bool may_have_joined = asked.failsafe && !alone && asked.accepted == schedule_.now();
  piece.sent += may_have_joined ? 0U : 1U;
  leave_queue(asked.pieces.size() == 1 || asked.kind == Kind::broadcast ? piece
                                                                        : asked.pieces.front());
  asked.maybe_on_wire = true;
  asked.surely_on_wire = asked.surely_on_wire || alone;
  note_write_event(asked, flight.bus);
  std::erase(books_[flight.bus].stops, &asked);
  if (!asked.replies &&
      std::ranges::all_of(asked.pieces, [](const Piece& it) { return it.sent > 0; })) {
    end_without_reply(asked);
  }
}

void Oracle::executed(const Flight& flight) {
  if (flight.is_stop) {
    books_[flight.bus].lanes[flight.address].stops_done[flight.pdu] = schedule_.now();
  }
  for (const std::uint64_t id : flight.asked) {
    if (const auto entry = open_.find(id); entry != open_.end()) {
      for (Piece& piece : entry->second->pieces) {
        if (piece.pdu == flight.pdu) {
          piece.done = {piece.executed ? piece.done.first : schedule_.now(), schedule_.now()};
          piece.executed = true;
        }
      }
    }
  }
}

void Oracle::echo_spoilt(const Flight& flight) {
  ++books_[flight.bus].count.spoilt_echoes;
  for (const std::uint64_t id : flight.asked) {
    if (const auto entry = open_.find(id); entry != open_.end()) {
      ++entry->second->spoilt;
    }
  }
}

void Oracle::excepted(const Flight& flight, std::uint8_t code) {
  for (const std::uint64_t id : flight.asked) {
    if (const auto entry = open_.find(id); entry != open_.end()) {
      entry->second->device_exceptions.set(code);
    }
  }
}

}  // namespace mbgate::soak
