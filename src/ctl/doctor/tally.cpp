// SPDX-License-Identifier: Apache-2.0
#include "ctl/doctor/tally.hpp"

#include <algorithm>
#include <iterator>

namespace mbgate::ctl {
namespace {

/// So many requests in a row without a byte: more of them say nothing new.
constexpr std::ptrdiff_t kGivenUp = 3;

/// `owed`: it may be the answer to the request before.
void count_answer(Tally& tally, const Trial& trial, std::chrono::nanoseconds timeout, bool owed) {
  ++tally.answered;
  tally.exceptions += trial.exception ? 1 : 0;
  if (!owed) {
    tally.times.push_back(trial.took);
    tally.late += trial.took > timeout ? 1 : 0;
    tally.doubled += trial.answers > 1 ? 1 : 0;
  }
}

}  // namespace

Tally tally_of(const UnitTrials& unit) {
  Tally tally;
  bool owed = false;
  for (const auto& trial : unit.trials) {
    ++tally.asked;
    tally.echoes += trial.echo ? 1 : 0;
    tally.other_client = tally.other_client || trial.other_client;
    switch (trial.kind) {
      case HeardKind::answer: count_answer(tally, trial, unit.unit.timeout, owed); break;
      case HeardKind::silence: ++tally.silent; break;
      case HeardKind::bad_crc: ++tally.bad_crcs; break;
      case HeardKind::noise: ++tally.noise; break;
      case HeardKind::other_frame: ++tally.others; break;
    }
    owed = trial.kind != HeardKind::answer;
    tally.most_bytes = owed ? std::max(tally.most_bytes, trial.bytes) : tally.most_bytes;
  }
  std::ranges::sort(tally.times);
  return tally;
}

bool is_given_up(const std::vector<Trial>& trials) {
  const auto count = std::ssize(trials);
  return count >= kGivenUp &&
         std::all_of(trials.end() - kGivenUp, trials.end(),
                     [](const Trial& trial) { return trial.kind == HeardKind::silence; });
}

}  // namespace mbgate::ctl
