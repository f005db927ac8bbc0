// SPDX-License-Identifier: Apache-2.0
#include "ctl/doctor/trial.hpp"

#include <algorithm>
#include <iterator>
#include <numeric>

#include "modbus/describe.hpp"

namespace mbgate::ctl {
namespace {

/// When byte number `place` came.
std::chrono::nanoseconds time_of(const std::vector<Piece>& pieces, std::size_t place) {
  std::size_t end = 0;
  for (const auto& piece : pieces) {
    end += piece.bytes.size();
    if (place < end) {
      // At a pseudo-terminal nothing takes the time that it takes on a wire.
      return std::max<std::chrono::nanoseconds>(piece.at, std::chrono::nanoseconds(0));
    }
  }
  return {};
}

bool is_request(const BusFrame& frame) { return frame.kind != FrameKind::response; }

std::string request_text(modbus::Bytes frame) {
  return modbus::describe_rtu(frame, modbus::Direction::request);
}

/// The last request among these bytes that is not ours, in words.
std::string other_request_in(const SentRead& sent, modbus::Bytes heard) {
  std::string text;
  for (const auto& frame : find_frames(heard).frames) {
    const auto bytes = heard.subspan(frame.begin, frame.size);
    if (is_request(frame) && !std::ranges::equal(bytes, sent.frame()) && !sent.answer_in(bytes)) {
      text = request_text(bytes);
    }
  }
  return text;
}

/// So many requests in a row without a byte: more of them say nothing new.
constexpr std::ptrdiff_t kGivenUp = 3;
/// Nor do more than so many of which none was answered, whatever was heard.
constexpr std::size_t kNeverAnswered = 5;
constexpr std::chrono::milliseconds kShortestAnswerWait{1000};

std::size_t without(std::size_t owed, std::size_t came) { return owed - std::min(owed, came); }

/// How many answers are owed when `trial` is over, where so many were before it.
std::size_t owed_at_end(std::size_t owed, const Trial& trial) {
  // A damaged answer is none that is still to come.
  return without(owed + 1, trial.kind == HeardKind::bad_crc ? 1 : trial.answers);
}

/// And when the next request is sent.
std::size_t owed_after(std::size_t owed, const Trial& trial) {
  return trial.settled ? 0 : without(owed_at_end(owed, trial), trial.after.late_answers);
}

/// `owed`: it may be the answer to a request before.
void count_answer(Tally& tally, const Trial& trial, std::chrono::nanoseconds timeout, bool owed) {
  ++tally.answered;
  tally.exceptions += trial.exception ? 1 : 0;
  if (!owed) {
    tally.times.push_back(trial.took);
    tally.late += trial.took > timeout ? 1 : 0;
    tally.doubled += trial.answers + trial.after.late_answers > 1 ? 1 : 0;
  } else if (trial.after.late_answers > 0) {
    ++tally.overdue;  // its own answer came afterwards, so this was that of before
  }
}

void count_disturbances(Tally& tally, const Trial& trial) {
  const bool other = !trial.other_client.empty() || !trial.after.other_client.empty();
  tally.other_client = tally.other_client || other;
  tally.disturbed = tally.disturbed || other || trial.after.is_foreign();
}

bool is_answered(const Trial& trial) {
  return trial.kind == HeardKind::answer || trial.after.late_answers > 0;
}

}  // namespace

bool Unasked::is_foreign() const { return bytes > kFewBytes || !other_client.empty(); }

Trial understand(const SentRead& sent, const std::vector<Piece>& pieces) {
  std::vector<std::uint8_t> all;
  for (const auto& piece : pieces) {
    all.insert(all.end(), piece.bytes.begin(), piece.bytes.end());
  }
  const auto heard = sent.understand(all);
  Trial trial{heard.kind};
  trial.bytes = heard.bytes;
  const auto echo = sent.echo_in(all);
  trial.echo = echo.has_value();
  if (heard.response && heard.response->is_exception()) {
    trial.exception = heard.response->bytes()[1];
  }
  // Divided at the echo: what is before it and its begin could look like a frame together.
  const auto begin = all.size() - heard.bytes;
  const auto rest = modbus::Bytes(all).subspan(begin);
  trial.other_client = other_request_in(sent, modbus::Bytes(all).first(echo.value_or(0)));
  if (trial.other_client.empty()) {
    trial.other_client = other_request_in(sent, rest);
  }
  for (const auto& frame : find_frames(rest).frames) {
    if (sent.answer_in(rest.subspan(frame.begin, frame.size)) && ++trial.answers == 1) {
      trial.took = time_of(pieces, begin + frame.begin);
    }
  }
  return trial;
}

Unasked understand_unasked(const modbus::TableRange& read, const std::vector<std::uint8_t>& asked,
                           modbus::Bytes heard) {
  const auto found = find_frames(heard);
  Unasked unasked;
  unasked.bytes = found.stray;
  for (const auto& frame : found.frames) {
    const auto bytes = heard.subspan(frame.begin, frame.size);
    const SentRead sent(frame.unit, read);
    const bool was_asked = std::ranges::find(asked, frame.unit) != asked.end();
    if (was_asked && std::ranges::equal(bytes, sent.frame())) {
      continue;  // a late echo
    }
    if (was_asked && sent.answer_in(bytes)) {
      unasked.late_answers += frame.unit == asked.back() ? 1 : 0;
    } else if (is_request(frame)) {
      unasked.other_client = request_text(bytes);
    } else {
      unasked.bytes += frame.size;
    }
  }
  return unasked;
}

Tally tally_of(const UnitTrials& unit) {
  Tally tally;
  std::size_t owed = 0;
  for (const auto& trial : unit.trials) {
    ++tally.asked;
    tally.echoes += trial.echo ? 1 : 0;
    tally.overdue += std::min<std::size_t>(owed_at_end(owed, trial), trial.after.late_answers);
    count_disturbances(tally, trial);
    switch (trial.kind) {
      case HeardKind::answer: count_answer(tally, trial, unit.unit.timeout, owed > 0); break;
      case HeardKind::silence: ++tally.silent; break;
      case HeardKind::bad_crc: ++tally.bad_crcs; break;
      case HeardKind::noise: ++tally.noise; break;
      case HeardKind::other_frame: ++tally.others; break;
    }
    if (trial.kind != HeardKind::answer) {
      tally.most_bytes = std::max(tally.most_bytes, trial.bytes);
    }
    owed = owed_after(owed, trial);
  }
  std::ranges::sort(tally.times);
  return tally;
}

std::vector<Tally> tallies_of(const std::vector<UnitTrials>& units) {
  std::vector<Tally> tallies;
  std::ranges::transform(units, std::back_inserter(tallies), &tally_of);
  return tallies;
}

Tally tally_of_line(const std::vector<Tally>& tallies) {
  Tally line;
  for (const auto& tally : tallies) {
    line.asked += tally.asked;
    line.answered += tally.answered;
    line.echoes += tally.echoes;
    line.other_client = line.other_client || tally.other_client;
    line.disturbed = line.disturbed || tally.disturbed;
  }
  return line;
}

std::chrono::nanoseconds answer_wait(const PlannedUnit& unit) {
  return std::max<std::chrono::nanoseconds>(2 * unit.timeout, kShortestAnswerWait);
}

std::size_t owed_answers(const std::vector<Trial>& trials) {
  return std::accumulate(trials.begin(), trials.end(), std::size_t{0}, &owed_after);
}

bool is_given_up(const std::vector<Trial>& trials) {
  const auto is_silent = [](const Trial& trial) {
    return trial.kind == HeardKind::silence && !is_answered(trial);
  };
  const bool fell_silent = std::ssize(trials) >= kGivenUp &&
                           std::all_of(trials.end() - kGivenUp, trials.end(), is_silent);
  return fell_silent ||
         (trials.size() >= kNeverAnswered && std::ranges::none_of(trials, &is_answered));
}

}  // namespace mbgate::ctl
