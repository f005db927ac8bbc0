// SPDX-License-Identifier: Apache-2.0
#include "ctl/doctor/tally.hpp"

#include <algorithm>
#include <iterator>
#include <numeric>

namespace mbgate::ctl {
namespace {

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
