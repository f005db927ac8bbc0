// SPDX-License-Identifier: Apache-2.0
// The line and its framer.
#include "explore/state_reader_parts.hpp"

namespace mbgate::explore {

void StateReader::read(const bus::LineDiscipline& line, const Sight& sight, Hash& hash) {
  // Only where the far end may close: use. After a reload only: not_before.
  const auto& [use, variant, not_before] = line;
  read(std::get<bus::SerialDiscipline>(variant), sight, hash);
}

void StateReader::read(const bus::SerialDiscipline& line, const Sight& sight, Hash& hash) {
  // Counted, shown or told only: counters, draining, heard, heard_at, unpaced_reported. Without a
  // driver that holds something: unsent, is_answerless. Empty when the machine was asked for its
  // actions: faults, refused, end.
  const auto& [settings, silence, paced, counters, faults, echo, framer, transaction, response_due,
               response_deadline, is_hurried, response_wait, owed, misfit, may_be_echo, refused,
               draining, heard, heard_at, unpaced_reported, unsent, is_answerless, end] = line;
  // A setting: timing.
  const auto& [its_settings, timing, pause, quiet_since, busy_since, settling_until,
               listening_until, turnaround_until, emission_ends] = silence;
  require(faults.empty() && !end, "a line has told everything");
  const bool is_running = transaction != nullptr;
  // A stop compares these with its own instants; others with now.
  const Duration before = sight.stop_waits ? kFarPast : Duration{0};
  hash.add(paced);
  hash.add(pause);
  hash.since(quiet_since, std::max({before, pause, sight.frame_slack}));
  hash.since(busy_since, before);
  hash.until(settling_until);
  hash.until(listening_until);
  hash.since(turnaround_until, before);
  hash.add(is_running);
  if (is_running) {  // otherwise what is left of the last one is compared with nothing but now
    hash.since(emission_ends, kFarPast);
    hash.since(response_due, kFarPast);
    hash.since(response_deadline, kFarPast);
    hash.add(is_hurried);
    hash.add(response_wait);
    hash.add(owed.size());
    for (const bus::OwedAnswer& it : owed) {
      hash.add(it.asked.pdu().bytes());
      hash.add(it.is_own);
    }
    hash.add(misfit);
    hash.add(may_be_echo);
  } else {
    hash.until(emission_ends);
  }
  read(echo, is_running, hash);
  const auto& [variant] = framer;
  read(std::get<bus::RtuFramer>(variant), hash);
}

void StateReader::read(const bus::Echo& echo, bool is_running, Hash& hash) {
  // A setting: learns. Told or counted only: counters, faults, unproven_reported. `asked`, at
  // `address`, is what the line asks, and is looked at only as long as it does, or if it is such a
  // read.
  const auto& [state, learns, counters, faults, address, asked, may_answer, expected, seen, owed,
               due, held, echoed, heard, spoilt, passed, shown, lost, unproven_reported] = echo;
  require(!may_answer || !asked || !modbus::is_read(asked->bytes()),
          "no read looks like its own answer");
  hash.add(state);
  hash.add(std::span(expected.data(), expected.size()));
  hash.add(seen);
  hash.add(owed.size());
  for (const bus::FrameBytes& frame : owed) {
    hash.add(std::span(frame.data(), frame.size()));
  }
  hash.add(echoed);
  for (std::size_t known = 0; known < heard.size(); ++known) {
    if (heard[known]) {
      hash.add(known);
    }
  }
  hash.add(spoilt);
  hash.add(shown);
  hash.add(lost);
  const bool may_be_owed = !expected.empty() || !owed.empty();
  if (is_running || may_be_owed) {
    hash.add(may_answer);
    hash.add(passed);
  }
  if (may_be_owed) {
    hash.since(due, kFarPast);
    hash.add(held.size());
    for (const bus::Echo::Piece& piece : held) {
      hash.add(piece.begin);
      hash.since(piece.came, kFarPast);
    }
  }
}

void StateReader::read(const bus::RtuFramer& framer, Hash& hash) {
  // Settings: timing, slack. Known by the line: sent, and until when it is hurried. Counted only:
  // counters. Set and read within one input: found. Empty when the machine was asked for its
  // actions: strays.
  const auto& [timing, slack, counters, transaction, sent, hurried, buffer, last_byte, answer,
               answer_at, given, answers_another, discarding, behind_frame, found, cut, strays] =
      framer;
  const Duration reach = std::max(timing.t3_5(), slack);
  hash.add(transaction != nullptr);
  hash.since(last_byte, reach);
  hash.add(answer);
  hash.add(answers_another);
  hash.add(discarding);
  hash.add(behind_frame);
  if (transaction != nullptr) {
    hash.add(given);
  }
  if (framer.in_progress()) {
    hash.add(answer_at);
    hash.add(hurried.has_value());
  }
  read(buffer, kFarPast, hash);
  read(cut, buffer.size() == 0, hash);
}

void StateReader::read(const bus::ReceivedBytes& received, Duration reach, Hash& hash) {
  const auto& [bytes, came] = received;
  hash.add(std::span(bytes.data(), bytes.size()));
  for (const Instant instant : came) {
    hash.since(instant, reach);
  }
}

// What is kept is thrown away when it is older than kLongestPauses and more bytes come; but what
// stands in the buffer may be put behind it before.
void StateReader::read(const bus::CutFrame& cut, bool is_last, Hash& hash) {
  const auto& [kept, begins, last, pause] = cut;
  const bool is_over = is_last && hash.now() - last > bus::kLongestPauses;
  if (kept.empty() || is_over) {
    hash.add(false);
    return;
  }
  hash.add(true);
  hash.add(std::span(kept.data(), kept.size()));
  for (std::size_t at = 0; at < kept.size(); ++at) {
    hash.add(begins.test(at));
  }
  hash.since(last, kFarPast);
  hash.add(pause);
}

}  // namespace mbgate::explore
