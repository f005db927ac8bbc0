// SPDX-License-Identifier: Apache-2.0
// What drives on a line hear, and how their answers go wrong.
#include <algorithm>

#include "world/line.hpp"

namespace mbgate::world {
namespace {

/// A drive cannot answer sooner.
constexpr Duration kLeast = 200us;

bool answers_with_data(const Octets& pdu) { return pdu[0] >= 1 && pdu[0] <= 4; }

}  // namespace

void Line::heard(Id id) {
  const Sent& sent = around_.ledger.sent[id];
  if (!sent.readable) {
    return;
  }
  for (const Station& station : around_.plan.stations) {
    if (station.bus != bus_ || (!sent.is_broadcast && station.address != sent.address) ||
        (sent.is_broadcast && station.other_broadcasts != sent.has_other_form)) {
      continue;
    }
    for (const std::size_t drive : station.drives) {
      ask(around_.drives[drive], id);
    }
  }
}

void Line::ask(Drive& drive, Id id) {
  const Instant now = around_.schedule.now();
  if (!drive.has_supply(now) || happens(drive.habits.deaf, "deaf")) {
    return;
  }
  if ((drive.habits.service == Duration{0} && drive.free() <= now) || is_calm_) {
    respond(drive, id);
    return;
  }
  around_.report.fault(drive.habits.freezes ? "asked_while_frozen" : "slow_drive");
  const Duration service = drive.habits.service;
  drive.free() = std::max(drive.free(), now) +
                 (drive.habits.freezes ? random_.duration(0ms, drive.habits.quick)
                                       : random_.duration(service * 9 / 10, service * 11 / 10));
  around_.schedule.at(drive.free(), [this, &drive, id] { respond(drive, id); });
}

void Line::lose_supply(std::size_t number) {
  const Habits& habits = around_.drives[number].habits;
  around_.schedule.after(
      random_.duration(habits.sleeps_every / 4, 2 * habits.sleeps_every), [this, number] {
        Drive& drive = around_.drives[number];
        if (is_calm_) {
          return;
        }
        const Duration longest = drive.habits.sleeps_for;
        const Instant until = around_.schedule.now() + random_.duration(longest / 10, longest);
        if (drive.habits.freezes) {
          around_.report.fault("frozen");
          drive.free() = std::max(drive.free(), until);
        } else {
          around_.report.fault("without_supply");
          drive.lose_supply(until);
        }
        lose_supply(number);
      });
}

void Line::respond(Drive& drive, Id id) {
  const Instant now = around_.schedule.now();
  if (!drive.has_supply(now)) {
    return;
  }
  Sent& sent = around_.ledger.sent[id];
  Octets pdu = sent.pdu;
  if (sent.is_broadcast) {
    drive.carry_out(around_.ledger, id, std::move(pdu), now);
    return;
  }
  const bool refuses = sent.is_stop
                           ? happens(drive.habits.refuses_stops, "stop_refused")
                           : !is_silent_write(pdu) && happens(drive.habits.exceptions, "exception");
  if (refuses) {
    const std::uint8_t code = sent.is_stop ? random_.one_of<std::uint8_t>({5, 6, 0x0A, 0x0B})
                                           : random_.one_of<std::uint8_t>({4, 5, 7, 0x11, 0x12});
    answer(drive, id, {static_cast<std::uint8_t>(pdu[0] | 0x80U), code});
    return;
  }
  const bool limits = pdu[0] == 0x06 && !sent.is_stop && !is_silent_write(pdu) &&
                      happens(drive.habits.limits, "limited");
  if (limits) {
    pdu[4] ^= 0x01U;  // what is written and echoed is another value
    sent.limited = true;
  }
  const auto done = drive.carry_out(around_.ledger, id, std::move(pdu), now);
  if (done && (limits || !happens(drive.habits.never, "never"))) {
    answer(drive, id, *done);
  }
}

Instant Line::begin_of(Drive& drive, const Sent& sent) {
  const Station& station = around_.plan.stations[*sent.station];
  const drive::DeviceTiming& timing = around_.plan.timing_of(station);
  const Instant now = around_.schedule.now();
  const Duration limit = timing.response_timeout + timing.response_wait;
  const Duration tail = quarantine_of(timing);
  if (happens(drive.habits.late, "late")) {
    return std::max(now,
                    sent.end + limit + random_.duration(0ms, std::max<Duration>(tail - 10ms, 1ms)));
  }
  if (happens(drive.habits.very_late, "very_late")) {
    return std::max(now, sent.end + limit + tail + random_.duration(1ms, 2 * limit));
  }
  const bool catches_up = drive.habits.freezes && drive.free() >= now;
  Duration wait = kLeast + timing.response_wait +
                  (catches_up ? Duration{0} : random_.duration(0us, drive.habits.quick));
  if (sent.reads && sent.reads->first < kSlowEnd &&
      sent.reads->first + sent.reads->count > kSlowFrom) {
    wait += random_.duration(0ms, timing.response_timeout / 2);
  }
  return now + wait;
}

void Line::answer(Drive& drive, Id id, const Octets& answer) {
  const Habits& habits = drive.habits;
  Sent& sent = around_.ledger.sent[id];
  Octets pdu = answer;
  Octets frame = encode(sent.address, pdu);
  Instant begin = begin_of(drive, sent);
  Instant& busy = talks_until_[drive.number()];
  begin = std::max(begin, busy + times_.silence());
  if (pdu[0] >= 0x80) {
    sent.exceptions |= 1U << pdu[1];
  }
  Came came;
  came.answers = id;
  came.fits = !sent.limited;
  std::size_t good = frame.size();
  Pause pause{0, Duration{0}};
  const Duration slack = slack_of(around_.plan.bus(bus_));
  // One at a time: of many behind each other the last would come long after all is calm.
  if (busy <= around_.schedule.now() && happens(habits.crawls, "crawl")) {
    constexpr Duration kStep = 600ms;
    const std::size_t most = ascii_ ? 48 : 8;
    frame.resize(std::min(frame.size(), most));
    sent.crawls = begin;
    for (const std::uint8_t byte : frame) {
      say({byte}, begin, 0, {}, {});
      begin += kStep;
    }
    busy = begin;
    return;
  }
  if (happens(habits.copies, "copy")) {
    const Octets once = frame;
    frame.insert(frame.end(), once.begin(), once.end());
  } else if (happens(habits.cut, "cut")) {
    frame.resize(random_.between<std::size_t>(1, frame.size() - 1));
    while (!ascii_ && ends_in_its_crc(frame)) {
      frame.pop_back();  // what ends in its own CRC is a frame, of a function that nobody knows
    }
    good = 0;
  } else if (spoil(habits, pdu, frame, came)) {
    good = frame.size();
  } else if (!ascii_ && answers_with_data(pdu) && happens(habits.glitches, "glitch")) {
    const std::size_t size = random_.between<std::size_t>(1, habits.most_glitches);
    frame.insert(frame.begin(), size, random_.one_of<std::uint8_t>({0x00, 0xFF, 0xF8}));
    good += size;
  } else if (!ascii_ && happens(habits.tails, "tail")) {
    // Zeros leave a CRC good: of a function that nobody knows they might be a part.
    const std::uint8_t byte =
        pdu[0] >= 0x40 && pdu[0] < 0x80 ? 0xFF : random_.one_of<std::uint8_t>({0x00, 0xFF});
    frame.insert(frame.end(), random_.between<std::size_t>(1, 3), byte);
  } else if (happens(habits.pauses, "pause")) {
    const auto kept = plan_.adapter == AdapterKind::uart ? 2ms : 20ms;
    pause = {random_.between<std::size_t>(1, frame.size() - 1),
             random_.duration(1ms, std::max<Duration>(slack - kept, 1ms))};
  } else if (happens(habits.long_pauses, "long_pause")) {
    pause = {random_.between<std::size_t>(1, frame.size() - 1),
             slack + random_.duration(25ms, 200ms)};
  }
  busy = begin + times_.of(frame.size()) + pause.length;
  if (happens(habits.second, "second_answer")) {
    Came second = came;
    second.is_second = true;
    say(frame, busy + times_.silence() + random_.duration(habits.second_from, habits.second_to),
        good, second, {});
  }
  say(std::move(frame), begin, good, came, pause);
}

// Damage is what a CRC or LRC finds for certain; a misfit has a good one. Of an ASCII character it
// leaves none that may stand in a frame.
bool Line::spoil(const Habits& habits, Octets& pdu, Octets& frame, Came& came) {
  if (happens(habits.damaged, "damaged")) {
    came.fits = false;
    if (habits.damages_check) {
      std::uint8_t& last = frame[frame.size() - (ascii_ ? 3U : 1U)];
      last = ascii_ ? (last == '0' ? '1' : '0') : last ^ 0x01U;
      came.ends_wait = true;
      return true;
    }
    constexpr std::size_t kHead = 3;  // who, what, and how much
    const std::size_t at = random_.below(frame.size() - (ascii_ ? 2U : 0U));
    frame[at] = low(ascii_ ? frame[at] | 0x80U : frame[at] ^ (1U << random_.below(8U)));
    came.ends_wait = !ascii_ && at >= kHead;
    return true;
  }
  if (pdu[0] >= 0x40 ||
      !happens(habits.misfits, "misfit")) {  // nobody knows what an unknown one says
    return false;
  }
  came.fits = false;
  came.ends_wait = true;
  switch (random_.between(0U, 2U)) {
    case 0:  // another function, which may be another client's
      pdu[0] ^= 0x05U;
      came.ends_wait = false;
      break;
    case 1:
      if (answers_with_data(pdu) && pdu.size() < 240) {
        pdu.insert(pdu.end(), {0xAA, 0xBB});
        pdu[1] = low(pdu[1] + 2U);
        break;
      }
      [[fallthrough]];
    default:
      if (pdu.size() < 5 || pdu[0] == 0x0B) {
        pdu.push_back(0x33);
      } else if (answers_with_data(pdu)) {
        pdu.resize(pdu.size() - 1);
        pdu[1] = low(pdu[1] - 1U);
      } else {
        pdu[1] ^= 0x40U;  // another address
      }
  }
  frame = encode(around_.ledger.sent[came.answers].address, pdu);
  return true;
}

}  // namespace mbgate::world
