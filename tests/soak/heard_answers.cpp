// SPDX-License-Identifier: Apache-2.0
#include "soak/heard_answers.hpp"

#include <algorithm>
#include <ranges>

#include "soak/identity.hpp"
#include "soak/oracle.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

namespace {

// As many bits as three bytes show, from 768 on: the address begins with the byte count.
bool looks_like_bits(const PduBytes& pdu) {
  constexpr std::uint8_t kBytes = 3;
  return (pdu[0] == 0x01 || pdu[0] == 0x02) && pdu[1] == kBytes &&
         (spec::word_at(pdu, 3) + 7U) / 8U == kBytes;
}

// An answer may be, with its CRC and all, how its own request begins.
bool begins_like_echo(Bytes bytes, const Flight& asked) {
  return bytes.size() > 1 && bytes.size() <= asked.pdu.size() && bytes[0] == asked.address &&
         std::equal(bytes.begin() + 1, bytes.end(), asked.pdu.begin());
}

}  // namespace

bool may_echo(const SoakPlan& plan, const Book& book, std::size_t bus) {
  return plan.echoes[bus] || book.echo_found || plan.settings.buses[bus].line.echo.value_or(false);
}

bool is_damaged_answer(const SoakPlan& plan, const Book& book, const Flight& asked) {
  const auto& settings = plan.settings.buses[asked.bus];
  const PduBytes& heard = book.heard;
  const bool may_be = settings.line.framing == bus::Framing::rtu && asked.expects_answer &&
                      heard.size() > 4 && heard[0] == asked.address && heard[1] == asked.pdu[0] &&
                      !spec::read_rtu(heard) && !may_echo(plan, book, asked.bus);
  const bool is_in_time = asked.first_came >= asked.end && book.use.first_read < asked.deadline &&
                          book.use.pause < spec::silence_of(settings) && book.read == book.came;
  if (!may_be || !is_in_time) {
    return false;
  }
  const auto fields = spec::fields_of(asked.pdu);
  if (fields && fields->reads) {
    const std::size_t size = spec::data_size_of(*fields->reads);
    return heard[2] == size && heard.size() == size + 5;
  }
  // Where an echo is possible, its rest is waited for.
  const bool may_be_echo = !settings.line.echo && begins_like_echo(heard, asked);
  return fields && fields->writes && heard.size() == 8 && asked.pdu[0] != 0x16 && !may_be_echo;
}

bool looks_like_answer(const Flight& flight) {
  const std::uint8_t function = flight.pdu.front();
  return !flight.is_broadcast &&
         (function == 0x05 || function == 0x06 || function == 0x08 || function == 0x15 ||
          function == 0x16 || spec::is_opaque(flight.pdu) || looks_like_bits(flight.pdu));
}

// Its answer stands behind its echo, where that can be nothing else.
bool HeardAnswers::is_behind_echo(const Flight& flight) const {
  const auto& unread = oracle_.books_[flight.bus].unread_echo;
  const bool is_whole =
      flight.has_whole_echo || (unread && unread->flight == flight.number && unread->is_whole);
  return is_whole && flight.pdu.size() > 1 && !looks_like_answer(flight) &&
         oracle_.bus_settings(flight.bus).line.echo != false;
}

// What stands behind an answer that is complete is no matter. Before it is only its echo; or what
// cannot be the beginning of an answer, and was ended by a silence.
bool HeardAnswers::is_apart_from_noise(const Flight& flight, const HeardFrame& frame,
                                       std::size_t echo) const {
  const Book& book = oracle_.books_[flight.bus];
  const std::size_t came = frame.lead > 0 ? book.came : frame.came;
  const std::size_t before = came - frame.size - frame.lead;
  if (before == echo) {
    return true;
  }
  if (echo > 0 || frame.lead > 0 || before > book.heard.size()) {
    return false;
  }
  const bool is_ascii = oracle_.bus_settings(flight.bus).line.framing == bus::Framing::ascii;
  const std::uint8_t beginning = is_ascii ? ':' : flight.address;
  const auto noise = Bytes(book.heard).first(before);
  return std::ranges::find(noise, beginning) == noise.end() &&
         (is_ascii || book.before_pause == before);
}

// The answer to a stop by 15 or 16 names no value: it may be taken for any of its function that is
// owed, and one that names it for that to the same stop of before another write. For how long one
// is owed follows from what was taken for late before, as this one may be. What is answered may
// have been in place of one like it before, so that it is owed itself.
bool HeardAnswers::may_be_for_earlier(const Flight& stop) const {
  if (!stop.is_stop) {
    return false;
  }
  const std::uint8_t function = stop.pdu.front();
  const bool names_value = function != 0x0F && function != 0x10;
  bool is_other_since = !names_value;
  Instant owed_until = Instant::min();
  for (const auto& it : oracle_.flights_ | std::views::reverse) {
    if (it->number >= stop.number || it->bus != stop.bus ||
        (it->address != stop.address && !it->is_broadcast)) {
      continue;
    }
    const bool is_alike = it->expects_answer && (names_value ? may_be_confused(it->pdu, stop.pdu)
                                                             : it->pdu.front() == function);
    if (is_alike && is_other_since) {
      const Duration longest = std::max(it->timing.quarantine_max, it->quarantine_until - it->due);
      owed_until = std::max(owed_until, it->due + longest + kAdapterHolds);
      if (!it->is_answered && stop.begin < owed_until) {
        return true;
      }
    }
    is_other_since = is_other_since || (it->is_write && !is_alike);
  }
  return false;
}

const char* HeardAnswers::why_unsure(const Flight& flight, const HeardFrame& frame) const {
  const Book& book = oracle_.books_[flight.bus];
  const auto& line = oracle_.bus_settings(flight.bus).line;
  if (frame.is_refused || frame.waits) {
    return "hurried";
  }
  if (!frame.is_only_debt || may_be_for_earlier(flight)) {
    return "beside_debts";
  }
  if (flight.is_uncertain) {
    return "uncertain";
  }
  // Alone it acknowledges nothing before the device was heard on this line.
  const auto& sent = book.lanes[flight.address].sent;
  const bool was_heard = std::ranges::any_of(sent, [&](std::uint64_t number) {
    const Flight* it = oracle_.flight(number);
    return it != nullptr && it->is_answered && it->begin >= book.opened;
  });
  if (looks_like_answer(flight) && !line.echo && !was_heard) {
    return "unproven";
  }
  if (asks_identity(flight.pdu) || spec::is_opaque(flight.pdu)) {
    return "ended_by_silence";
  }
  const bool has_echo = may_echo(oracle_.plan_, book, flight.bus);
  if (has_echo && !is_behind_echo(flight)) {
    return "beside_echo";
  }
  // Even where no echo is expected its rest is waited for.
  const std::size_t echo = has_echo ? flight.size : 0;
  if (begins_like_echo(Bytes(book.heard).subspan(std::min(echo, book.heard.size())), flight)) {
    return "like_its_request";
  }
  // Before `response_wait` is over it may be taken for one that is owed.
  if (frame.began < flight.end + flight.timing.response_wait) {
    return "early";
  }
  if (frame.began >= flight.deadline) {
    return "late";
  }
  const bool is_by_06 = flight.is_stop && flight.pdu.front() == 0x06;
  if (book.open_stops.size() > (is_by_06 ? 1U : 0U)) {
    return kBesideStop.data();
  }
  const bool is_in_one = line.framing == bus::Framing::ascii
                             ? book.use.pause <= 1s
                             : frame.ended < frame.began +
                                                 spec::slack_of(oracle_.bus_settings(flight.bus)) +
                                                 spec::WireTimes(line).of(frame.size);
  if (!is_in_one) {
    return "paused";
  }
  if (!is_apart_from_noise(flight, frame, echo)) {
    return "beside_noise";
  }
  return oracle_.reloaded_ >= flight.begin || flight.begin < book.opened ? "reload" : nullptr;
}

}  // namespace mbgate::soak
