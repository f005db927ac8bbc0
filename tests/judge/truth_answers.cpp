// SPDX-License-Identifier: Apache-2.0
// A value that a client got was in that drive's registers between the request's arrival (less the
// cache) and the answer; an acknowledged write was done; a refused one was not sent (promise 2 in
// docs/behaviour.md).
#include <algorithm>

#include "judge/judge.hpp"

namespace mbgate::judge {
namespace {

constexpr std::uint8_t kNotNow = 0x06;
constexpr std::uint8_t kNoPath = 0x0A;
constexpr std::uint8_t kNoAnswer = 0x0B;

bool is_on_wire(const Asked& asked) { return !asked.sent.empty(); }

}  // namespace

void Judge::check_exception(const Asked& asked) {
  const std::uint8_t code = asked.answer.size() == 2 ? asked.answer[1] : 0;
  const bool is_own = code < 16 && (asked.intent.codes >> code & 1U) != 0;
  const bool is_the_drives = std::ranges::any_of(
      asked.sent, [&](Id id) { return (ledger_.sent[id].exceptions >> code & 1U) != 0; });
  if (asked.intent.refused) {
    if (!is_own && code != kNotNow && !asked.perhaps_outdated) {
      violation("refused_otherwise", name(asked));
    }
    return;
  }
  if (is_own || is_the_drives) {
    return;
  }
  const bool is_write = asked.intent.kind != Kind::read;
  switch (code) {
    case kNotNow:
    case kNoPath:
      if (is_write && is_on_wire(asked) && asked.intent.buses.size() < 2) {
        note_exception(asked, "sent_and_refused");
      }
      break;
    case kNoAnswer:
      if (is_write && !is_on_wire(asked)) {
        violation("not_sent_and_uncertain", name(asked));
      }
      break;
    default: note_exception(asked, "nobodys_exception"); break;
  }
}

// Perhaps it is what the drive said to another request.
void Judge::note_exception(const Asked& asked, const char* kind) {
  const auto station = asked.intent.station;
  const auto is_said_to = [&](Id id) {
    return id != kNone && ledger_.sent[id].station == station &&
           (ledger_.sent[id].exceptions >> asked.answer[1] & 1U) != 0;
  };
  const bool has_said =
      station && (std::ranges::any_of(ledger_.last_sent[*station], is_said_to) ||
                  std::ranges::any_of(ledger_.lines[plan_.stations[*station].bus].came, is_said_to,
                                      &Came::answers));
  if (has_said) {
    note_wrong(asked, "exception");
  } else if (!station || !is_check_by_chance(plan_.stations[*station].bus)) {
    violation(kind, name(asked));
  }
}

// Noise inside an answer may make its check good, once in 65,536 times.
bool Judge::is_check_by_chance(std::size_t bus) {
  return !plan_.has_identifiers(bus) && ledger_.lines[bus].came.back().answers == kNone &&
         report_.apart["check_by_chance"]++ == 0;
}

// Of two drives at one address either may have said it.
bool Judge::held(const Station& station, Table table, unsigned first,
                 std::span<const std::uint16_t> words, Span span) const {
  return std::ranges::any_of(station.drives, [&](std::size_t drive) {
    return world_.drives()[drive].registers().held(table, first, words, span);
  });
}

bool Judge::shows(const Asked& asked) const {
  const Range& range = *asked.intent.reads;
  const Octets& answer = asked.answer;
  const Station& station = plan_.stations[*asked.intent.station];
  const drive::Device* device = plan_.device_of(station);
  const Span span{oldest_of(asked, device), now()};
  if (is_bits(range.table)) {
    for (unsigned at = 0; at < range.count; ++at) {
      const std::uint16_t bit = answer[2 + at / 8] >> at % 8 & 1U;
      if (!held(station, range.table, range.first + at, {&bit, 1}, span)) {
        return false;
      }
    }
    return true;
  }
  const bool moves = asked.intent.swapped && range.table == Table::holding_registers;
  const auto moved = [&](unsigned address) { return moves ? partner_of(address) : address; };
  const unsigned end = range.first + range.count;
  for (unsigned at = range.first; at < end;) {
    const bool is_value = range.table == Table::holding_registers &&
                          value_begin(at) >= range.first && value_end(at) <= end;
    const unsigned next = is_value ? value_end(at) : at + 1;
    const unsigned place = is_value ? at : moved(at);  // in the drive
    std::vector<std::uint16_t> words;
    for (unsigned part = 0; part < next - at; ++part) {
      words.push_back(word_at(answer, 2 + 2 * std::size_t{moved(place + part) - range.first}));
    }
    if (!held(station, range.table, place, words, span)) {
      return false;
    }
    at = next;
  }
  return true;
}

// An answer that names no register ends in the drive's first input registers, which no other drive
// has.
bool Judge::shows_inputs(const Asked& asked) const {
  constexpr std::size_t kData = 4;
  if (asked.answer.size() <= kData) {
    return false;
  }
  const Span span{oldest_of(asked, plan_.device_of(plan_.stations[*asked.intent.station])), now()};
  for (std::uint16_t at = 0; at < 2; ++at) {
    const std::uint16_t word = word_at(asked.answer, asked.answer.size() - kData + 2U * at);
    if (!held(plan_.stations[*asked.intent.station], Table::input_registers, at, {&word, 1},
              span)) {
      return false;
    }
  }
  return true;
}

void Judge::check_read(Id id) {
  const Asked& asked = ledger_.asked[id];
  const Intent& intent = asked.intent;
  if (intent.is_odd_read && asked.answer[0] != 0x07 && !shows_inputs(asked)) {
    note_wrong(asked, "odd_value");
  }
  if (!intent.reads || asked.outdated || asked.perhaps_outdated) {
    return;
  }
  const std::size_t size = data_size_of(*intent.reads);
  if (asked.answer.size() != 2 + size || asked.answer[1] != size) {
    note_wrong(asked, "other_length");
    return;
  }
  shows(asked) ? note_right(asked) : note_wrong(asked, "value");
}

bool Judge::was_done(const Asked& asked) const {
  return std::ranges::all_of(asked.intent.writes, [&](const Cell& cell) {
    const auto found = ledger_.doers.find(key_of(*asked.intent.station, cell));
    return found != ledger_.doers.end() && std::ranges::any_of(found->second, [&](Id done) {
             return ledger_.done[done].at >= asked.given;
           });
  });
}

void Judge::check_write(Id id) {
  const Asked& asked = ledger_.asked[id];
  const Intent& intent = asked.intent;
  constexpr std::size_t kHead = 5;  // of 15 and 16
  if (intent.pdu[0] == 0x17) {
    check_read(id);
  } else {
    const bool is_run = intent.pdu[0] == 0x0F || intent.pdu[0] == 0x10;
    const Octets echo(intent.pdu.begin(), is_run ? intent.pdu.begin() + kHead : intent.pdu.end());
    const bool is_limited =
        std::ranges::any_of(asked.sent, [&](Id sent) { return ledger_.sent[sent].limited; });
    // Of a function that nobody knows, zeros behind an answer may be a part: the CRC is good then
    // too.
    const bool is_known = intent.pdu[0] < 0x40;
    const bool is_echo =
        is_known ? asked.answer == echo
                 : std::ranges::equal(
                       echo, Bytes(asked.answer).first(std::min(echo.size(), asked.answer.size())));
    if (!is_echo && !is_limited) {
      note_wrong(asked, "other_echo");
      return;
    }
    if (is_limited) {
      return;
    }
  }
  if (asked.outdated || asked.perhaps_outdated) {
    return;
  }
  if (intent.kind == Kind::broadcast || intent.silent) {
    if (!is_on_wire(asked)) {
      violation("echoed_unsent", name(asked));
    }
  } else if (!was_done(asked)) {
    note_wrong(asked, intent.kind == Kind::stop ? "stop_not_done" : "not_done");
  } else {
    note_right(asked);
  }
}

void Judge::note_right(const Asked& asked) { ++slips_[*asked.intent.station].right; }

void Judge::note_echo_shown(const Asked& asked) {
  if (asked.sent.empty()) {
    return;
  }
  const Sent& sent = ledger_.sent[asked.sent.back()];
  ShowsEcho& shows = shows_echo_[sent.bus];
  if (shows.opening != sent.opening) {
    shows = {sent.opening, 0, kNever};
  }
  constexpr unsigned kSurely = 3;  // the echo of one may be damaged
  shows.at = ++shows.reads == kSurely ? now() : shows.at;
}

// Whether a line has an echo is known when clients have got what reads have brought (section 4).
// Until then an echo may acknowledge a write, whose own answer then comes for the next request.
bool Judge::is_echo_unknown(const Asked& asked, const Came& last) const {
  const std::size_t bus = plan_.stations[*asked.intent.station].bus;
  // A client's 16 may have gone out as 06.
  const auto took_echo = [&](const Asked& it) {
    const bool went_as_06 = !it.sent.empty() && ledger_.sent[it.sent.back()].pdu[0] == 0x06;
    return it.answer == it.intent.pdu || (went_as_06 && !it.answer.empty() && it.answer[0] < 0x80);
  };
  const auto is_behind_echo = [&](Id id) {
    return took_echo(ledger_.asked[id]) && ledger_.asked[id].answered < last.at;
  };
  const auto shown = shows_echo_.find(bus);
  const Instant asked_at = asked.sent.empty() ? asked.given : ledger_.sent[asked.sent.back()].begin;
  const bool is_shown = shown != shows_echo_.end() &&
                        shown->second.opening == ledger_.lines[bus].openings &&
                        shown->second.at <= asked_at;
  return plan_.lines[bus].echoes && !plan_.bus(bus).line.echo && !is_shown &&
         (took_echo(asked) ||
          std::ranges::any_of(ledger_.sent[last.answers].asked, is_behind_echo));
}

// Some wrong answers nobody can help: until a device has shown how late it can be, or that it
// answers twice. They are few, and then there are none.
void Judge::note_wrong(const Asked& asked, const char* kind) {
  constexpr unsigned kMost = 12;
  constexpr unsigned kForgotten = 200;
  const std::size_t at = *asked.intent.station;
  const Station& station = plan_.stations[at];
  const auto& came = ledger_.lines[station.bus].came;
  const auto last = std::find_if(came.rbegin(), came.rend(), [&](const Came& it) {
    return it.answers != kNone && ledger_.sent[it.answers].station == at;
  });
  if (plan_.has_identifiers(station.bus) || last == came.rend()) {
    violation(kind, name(asked));
    return;
  }
  if (is_echo_unknown(asked, *last)) {
    ++report_.apart["echo_unknown"];
    return;
  }
  const Sent& from = ledger_.sent[last->answers];
  const bool is_special = std::ranges::any_of(station.drives, [&](std::size_t drive) {
    const Habits& habits = plan_.drives[drive].habits;
    return habits.service > 0ms || habits.second > 0 || station.drives.size() > 1;
  });
  // A stop waits for no answer to the one before: what refuses that may pass for its own.
  const bool is_refusal = asked.intent.kind == Kind::stop && asked.answer[0] >= 0x80;
  if (!is_special && (is_refusal || is_later_than_ever(asked, *last))) {
    ++report_.apart[is_refusal ? "stale_refusal" : "later_than_ever"];
    return;
  }
  Slips& slips = slips_[at];
  if (!is_special) {
    if (!is_check_by_chance(station.bus)) {
      violation(kind, name(asked) + ", from " + name(from));
    }
    return;
  }
  if (slips.process != ledger_.process || slips.right >= kForgotten) {
    slips.wrong = slips.stale = 0;
  }
  slips.process = ledger_.process;
  slips.right = 0;
  const bool is_shared = std::exchange(slips.last, last->at) == last->at;
  // What it said to the same question a moment before cannot be told from the answer to this one.
  const bool is_same =
      is_refusal || (!asked.sent.empty() && from.pdu == ledger_.sent[asked.sent.back()].pdu);
  ++report_.apart[std::string(is_same ? "learning_stale_" : "learning_") + kind];
  constexpr unsigned kMostStale = 40;
  if (!is_shared && ++(is_same ? slips.stale : slips.wrong) > (is_same ? kMostStale : kMost)) {
    violation("wrong_too_often", name(asked) + ", " + kind + ", " + std::to_string(slips.wrong));
  }
}

}  // namespace mbgate::judge
