// SPDX-License-Identifier: Apache-2.0
// What the oracle asks of a line: silence, the turnaround delay, quarantine, stops before all else.
#include <algorithm>
#include <utility>

#include "soak/oracle.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

namespace {

/// How the address and a function begin a frame; in ASCII they are four digits.
spec::Octets name_of(std::uint8_t address, unsigned function, bool is_ascii) {
  const auto code = static_cast<std::uint8_t>(function);
  if (!is_ascii) {
    return {address, code};
  }
  const auto frame = spec::ascii_frame(address, Bytes(&code, 1));
  return {frame.begin() + 1, frame.begin() + 5};
}

}  // namespace

// Of one connection and one device, always in order.
void Oracle::check_order(const Asked& asked, const Flight& flight) {
  Book& book = books_[flight.bus];
  const auto check = [&](const Lane& lane) {
    for (const Asked* other : lane.open) {
      // A merged read that has failed is sent in its parts.
      const bool was_merged = asked.maybe_on_wire && other->is_read() &&
                              other->pieces.size() == 1 && other->flights_alone == 0 &&
                              other->last_sent != other->pieces.front().pdu;
      const bool waits = std::ranges::any_of(other->pieces, [&](const Piece& piece) {
        return piece.bus == flight.bus && (piece.sent == 0 || was_merged) && !piece.doomed &&
               !piece.taken_back;
      });
      // One part of a broadcast may have ended while others wait.
      const bool ended =
          other->pieces.size() > 1 && other->kind == Kind::broadcast &&
          (std::max({book.last_full, book.last_down, book.last_stop}) >= other->accepted ||
           schedule_.now() >= other->deadline - (other->written - other->earliest));
      if (other->client == asked.client && other->sequence < asked.sequence && waits && !ended &&
          !other->is_stop() && !other->doomed && !other->dropped && is_surely_open(*other)) {
        violation("order", name(asked) + " before " + name(*other));
      }
    }
  };
  check(book.lanes[flight.address]);
  if (asked.kind != Kind::broadcast && !is_tcp(flight.bus)) {
    check(book.lanes[0]);
  }
}

void Oracle::check_silence(const Flight& flight) {
  const Book& book = books_[flight.bus];
  const auto& settings = bus_settings(flight.bus);
  Duration silence = spec::silence_of(settings);
  const auto& device = book.lanes[flight.address].device;
  if (device && !flight.is_stop) {
    silence += devices_[*device].settings().timing.gap;
  }
  if (flight.begin < book.own_end) {
    violation("overlap", name(flight));
  } else if ((flight.begin < book.own_end + silence || flight.begin < book.last_byte + silence) &&
             !may_break_silence(flight)) {
    violation("silence", name(flight));
  } else if (flight.begin < book.last_byte + silence) {
    report_.fault("stop_forced");
  }
  if (flight.begin < book.turnaround_end) {
    violation("turnaround", name(flight));
  }
}

void Oracle::bytes_handed_in(std::size_t bus) {
  Book& book = books_[bus];
  if (book.use.first_read == Instant::min()) {
    book.use.first_read = schedule_.now();
    book.use.pause = Duration{0};
  } else {
    book.use.pause = std::max(book.use.pause, schedule_.now() - book.last_handed_in);
  }
  const auto& settings = bus_settings(bus);
  const Duration silence = spec::silence_of(settings);
  const Instant now = schedule_.now();
  if (now >= book.last_handed_in + std::max(silence, spec::WireTimes(settings.line).silence())) {
    book.before_pause = book.read;
  }
  if (is_tcp(bus)) {
    read_answers(bus);
  } else {
    read_frames(bus);
    read_echo(bus);
  }
  if (now > std::max(book.last_handed_in, book.own_end) + silence) {
    book.busy_since = now;
  }
  book.last_handed_in = now;
}

// A stop that waits long enough cuts what is in its way: what goes to the same device, and what has
// the last place. From outside nobody sees whether one that is open waits: for the writes before
// it, or once more because it had no answer.
Instant Oracle::deadline_of(const Flight& flight) const {
  Instant deadline = flight.deadline;
  for (const Asked* stop : books_[flight.bus].open_stops) {
    if (flight.is_crowded || stop->pieces.front().address == flight.address) {
      deadline = std::min(
          deadline, std::max(flight.begin, stop->accepted + bus_settings(flight.bus).stop_wait));
    }
  }
  return deadline;
}

void Oracle::cut_flying(const Book& book) {
  for (const std::uint64_t number : book.flying) {
    if (Flight* other = flight(number)) {
      other->deadline = deadline_of(*other);
    }
  }
}

void Oracle::check_tcp(const Flight& flight) {
  auto& flying = books_[flight.bus].flying;
  std::erase_if(flying, [&](std::uint64_t number) {
    const Flight* other = this->flight(number);
    return other == nullptr || schedule_.now() >= other->deadline;
  });
  for (const std::uint64_t number : flying) {
    const Flight& other = *this->flight(number);
    if (other.identifier == flight.identifier) {
      violation("tcp_identifier", name(flight));
    }
    // A stop waits for no read of its device, and nothing goes beside a stop.
    const bool may_go = (!other.is_write && (flight.is_stop || !flight.is_write)) ||
                        flight.is_failsafe || other.is_failsafe;
    if (other.address == flight.address && !may_go) {
      violation("tcp_beside_write", name(flight) + " while " + name(other));
    }
  }
  const bool is_full = flying.size() >= bus_settings(flight.bus).outstanding;
  if (is_full && !flight.is_stop && !has_failsafe(flight.bus)) {  // which may have cut one

    violation("tcp_outstanding", name(flight));
  }
  flying.push_back(flight.number);
  // The gateway learns that a timeout is over when a deadline is handed in. What it reads before
  // that may let something else go, or be the end of the connection, which then cuts both.
  auto& unheard = books_[flight.bus].unheard;
  std::erase_if(unheard, [&](std::uint64_t number) {
    const Flight* other = this->flight(number);
    return other == nullptr || judged_ >= other->due;
  });
  unheard.push_back(flight.number);
  note_crowded(flight.bus);
}

// Those on a connection that has no place for one more, by the settings in force.
void Oracle::note_crowded(std::size_t bus) {
  const auto& unheard = books_[bus].unheard;
  if (unheard.size() >= bus_settings(bus).outstanding) {
    for (const std::uint64_t number : unheard) {
      if (Flight* it = flight(number)) {
        it->is_crowded = true;
      }
    }
  }
}

void Oracle::set_times(Flight& flight) {
  Lane& lane = books_[flight.bus].lanes[flight.address];
  drive::DeviceTiming timing = bus_settings(flight.bus).timing;
  Duration longest = timing.response_timeout;
  flight.timing = timing;
  if (lane.device) {
    const drive::Device& device = devices_[*lane.device].settings();
    flight.timing = timing = device.timing;
    timing.quarantine = spec::quarantine_of(device.timing);
    if (is_slow(flight.pdu)) {
      timing.response_timeout =
          std::max(timing.response_timeout, device.profile.slow.front().response_timeout);
    }
    longest = std::max(timing.response_timeout, spec::probe_timeout_of(timing));
    if (is_surely_offline(lane)) {
      longest = spec::probe_timeout_of(timing);
    }
    if (is_past_offline(flight.bus, lane)) {
      timing.response_timeout = std::min(timing.response_timeout, spec::probe_timeout_of(timing));
    }
  }
  flight.deadline = flight.end + timing.response_timeout + timing.response_wait;
  flight.due = flight.end + longest + timing.response_wait;
  flight.quarantine_until = flight.deadline + spec::quarantine_of(timing) + kAdapterHolds;
  if (is_tcp(flight.bus)) {
    flight.deadline = deadline_of(flight);
  }
}

void Oracle::tcp_answer_came(std::uint64_t number) {
  if (Flight* answered = flight(number)) {
    answered->deadline = deadline_of(*answered);
    answered->is_answered = schedule_.now() < answered->deadline && reloaded_ < answered->begin;
    if (answered->refused) {
      answered->refused_at = schedule_.now();
    }
    books_[answered->bus].unread_answers.push_back(number);
    note_excused(*answered);
    std::erase(books_[answered->bus].flying, number);
    std::erase(books_[answered->bus].unheard, number);
  }
}

void Oracle::check_waiting() {
  for (std::size_t bus = 0; bus < books_.size(); ++bus) {
    Book& book = books_[bus];
    if (book.waiting > std::max(bus_settings(bus).queue, book.room)) {
      violation("queue_limit", bus_settings(bus).name + ": " + std::to_string(book.waiting));
    }
    book.room = std::min(book.room, book.waiting);
    check_rest(bus);
    check_stops_waiting(bus);
  }
}

std::string Oracle::name(const Asked& asked) const {
  constexpr char kDigits[] = "0123456789ABCDEF";
  std::string text = "client " + std::to_string(static_cast<std::uint64_t>(asked.client)) +
                     " transaction " + std::to_string(asked.transaction) + " unit " +
                     std::to_string(asked.unit) + " pdu ";
  for (const std::uint8_t byte : asked.pdu) {
    text += {kDigits[byte >> 4U], kDigits[byte & 15U]};
  }
  if (!asked.pieces.empty()) {
    text += " (" + bus_settings(asked.pieces.front().bus).name + " address " +
            std::to_string(asked.pieces.front().address) + ")";
  }
  return text;
}

void Oracle::bytes_came(std::size_t bus, Bytes bytes) {
  Book& book = books_[bus];
  book.last_byte = schedule_.now();
  book.came += bytes.size();
  book.in_vain.clear();
  Flight* last = flight(book.last_flight);
  if (last == nullptr || last->pdu.empty() || bytes.empty()) {
    return;
  }
  last->came = book.came;
  if (std::exchange(last->needs_silence, false)) {
    last->is_answered = false;
    last->unsure = "beside_noise";
  }
  last->first_came = std::min(last->first_came, schedule_.now());
  const bool is_ascii = bus_settings(bus).line.framing == bus::Framing::ascii;
  const auto answer = name_of(last->address, last->pdu[0], is_ascii);
  const auto exception = name_of(last->address, last->pdu[0] | 0x80U, is_ascii);
  for (const std::uint8_t byte : bytes) {
    if (book.heard.size() <= spec::kRtuFrame) {
      book.heard.push_back(byte);
    }
    std::ranges::rotate(book.tail, book.tail.begin() + 1);
    book.tail.back() = byte;
    const Bytes tail = Bytes(book.tail).last(answer.size());
    last->is_named =
        last->is_named || std::ranges::equal(tail, answer) || std::ranges::equal(tail, exception);
  }
}

const gateway::BusSettings& Oracle::bus_settings(std::size_t bus) const {
  return plan_.settings.buses[bus];
}

bool Oracle::is_tcp(std::size_t bus) const {
  return bus_settings(bus).line.framing == bus::Framing::tcp;
}

}  // namespace mbgate::soak
