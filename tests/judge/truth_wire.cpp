// SPDX-License-Identifier: Apache-2.0
// One transaction at a time on a line, with the silence that the standard requires (promise 1), and
// a drive that may still answer is left alone (promise 5 in docs/behaviour.md).
#include <algorithm>
#include <ranges>

#include "judge/judge.hpp"

namespace mbgate::judge {
namespace {
// The gateway counts in the same nanoseconds; only the drivers' clocks differ.
constexpr Duration kRounding = 1us;
}  // namespace

void Judge::check_silence(Id id) {
  const Sent& sent = ledger_.sent[id];
  const LineBook& line = ledger_.lines[sent.bus];
  if (!line.open || plan_.is_tcp(sent.bus)) {
    return;
  }
  const auto& bus = plan_.bus(sent.bus);
  const Duration silence = silence_of(bus);
  if (line.last != kNone) {
    const Sent& before = ledger_.sent[line.last];
    if (sent.begin + kRounding < before.end) {
      violation("overlap", name(sent) + " into " + name(before));
    } else if (sent.begin + kRounding < before.end + silence) {
      violation("silence", name(sent) + " behind " + name(before));
    }
    const bool is_waiting = before.is_broadcast && sent.begin < before.end + bus.turnaround;
    if (is_waiting && ledger_.reloaded < before.begin) {
      violation("turnaround", name(sent) + " behind " + name(before));
    }
  }
  const bool may_break_in = sent.is_stop || sent.is_failsafe;  // where a line is never silent
  if (!may_break_in && line.said > line.opened && sent.begin + kRounding < line.said + silence) {
    violation("silence", name(sent) + " behind an answer");
  }
}

// `gap_after_write`, at least from when the write has left.
void Judge::check_gap(Id id) {
  constexpr Id kFarBack = 64;
  const Sent& sent = ledger_.sent[id];
  if (!sent.station || sent.is_stop || sent.is_failsafe) {
    return;
  }
  const Duration gap = plan_.timing_of(plan_.stations[*sent.station]).gap_after_write;
  for (Id at = id; gap > 0ms && at > 0 && at + kFarBack > id; --at) {
    const Sent& before = ledger_.sent[at - 1];
    if (before.station == sent.station && !before.cells.empty() && !before.is_broadcast &&
        before.process == sent.process && ledger_.reloaded < before.begin &&
        sent.begin + kRounding < before.end + gap) {
      violation("gap", name(sent) + " behind " + name(before));
    }
  }
}

// Where nothing at all came, an answer may still come until its timeout.
void Judge::check_waiting(Id id) {
  const Sent& sent = ledger_.sent[id];
  const LineBook& line = ledger_.lines[sent.bus];
  if (plan_.is_tcp(sent.bus) || line.last == kNone || !line.open || sent.is_stop ||
      sent.is_failsafe) {
    return;
  }
  const Sent& before = ledger_.sent[line.last];
  if (!before.expects_answer || !before.station || line.heard >= before.begin ||
      ledger_.reloaded >= before.begin || before.opening != line.openings) {
    return;
  }
  const drive::DeviceTiming& timing = plan_.timing_of(plan_.stations[*before.station]);
  const Duration least = std::min(timing.response_timeout, probe_timeout_of(timing));
  const bool is_stop = before.is_stop || before.is_failsafe;
  const Duration limit =
      is_stop ? std::min(plan_.bus(sent.bus).stop_wait, least) : timing.response_wait + least;
  // A failsafe write may have cut the wait and was dropped then, because its client asked again.
  const auto drops_failsafe = [&](const Asked& asked) {
    const auto& at = asked.intent.station;
    const bool asks =
        at ? plan_.stations[*at].bus == sent.bus && plan_.has_failsafe(plan_.stations[*at])
           : asked.intent.kind == Kind::broadcast;
    return asks && asked.given > before.begin - 500ms;  // it may have been read later
  };
  if (sent.begin + kRounding < before.end + limit &&
      std::ranges::none_of(ledger_.asked, drops_failsafe)) {
    violation("impatient", name(sent) + " behind " + name(before) + ", after " +
                               std::to_string((sent.begin - before.end) / 1us) + " us, not " +
                               std::to_string(limit / 1us));
  }
}

void Judge::check_hold(Id id) {
  const Sent& sent = ledger_.sent[id];
  if (!sent.station || sent.is_stop || sent.is_failsafe || plan_.has_identifiers(sent.bus)) {
    return;
  }
  const drive::DeviceTiming& timing = plan_.timing_of(plan_.stations[*sent.station]);
  const LineBook& line = ledger_.lines[sent.bus];
  for (const Id other : ledger_.last_sent[*sent.station]) {
    const Sent& before = ledger_.sent[other];
    const bool is_silent = line.heard < before.begin && before.answered == kNever;
    const bool is_other = before.pdu[0] != sent.pdu[0];
    const bool is_retry = before.pdu == sent.pdu && sent.cells.empty();
    if (!before.expects_answer || !is_silent || is_other || is_retry ||
        before.process != ledger_.process || before.begin <= ledger_.reloaded) {
      continue;
    }
    const Instant until = before.end + std::min(timing.response_timeout, probe_timeout_of(timing)) +
                          timing.response_wait + quarantine_of(timing);
    if (sent.begin + kRounding < until) {
      violation("hold", name(sent) + " behind " + name(before));
      return;
    }
  }
}

// Half an answer in the stream at its timeout: what comes on this connection can no more be told
// apart, so nothing else is asked there.
void Judge::check_half(Id id) {
  const Sent& sent = ledger_.sent[id];
  const LineBook& line = ledger_.lines[sent.bus];
  if (line.halved == kNone || ledger_.sent[line.halved].opening != sent.opening) {
    return;
  }
  const Sent& halved = ledger_.sent[line.halved];
  const auto breaks_in = [&](const Sent& it) {
    return it.bus == sent.bus && (it.is_stop || it.is_failsafe);
  };
  // A stop cuts the wait; and half an answer of two bytes might be another request's.
  if (plan_.bus(sent.bus).outstanding > 1 ||
      std::any_of(ledger_.sent.begin() + line.halved, ledger_.sent.begin() + id + 1, breaks_in)) {
    return;
  }
  const drive::DeviceTiming& timing = plan_.timing_of(plan_.stations[*halved.station]);
  constexpr Duration kLateness = 60ms;
  const Duration least = std::min(timing.response_timeout, probe_timeout_of(timing));
  if (line.halved_at > halved.end + least) {
    return;  // it was late: no timeout has found it yet
  }
  if (ledger_.reloaded < halved.begin && !plan_.driver.stalls && !plan_.driver.stops &&
      sent.begin > halved.end + longest_wait_of(*halved.station) + kLateness) {
    violation("half_an_answer", name(sent) + " behind a part of the answer to " + name(halved));
  }
}

// What an adapter still holds at the response timeout never leaves it: the line is lost, and the
// driver drops it.
void Judge::check_heard(Id id) {
  const Sent& sent = ledger_.sent[id];
  constexpr Duration kLateness = 200ms;
  const Instant until = sent.end + waits_.at(id);
  if (sent.heard == kNever || plan_.driver.stalls || plan_.driver.stops ||
      sent.heard <= until + kLateness) {
    return;
  }
  // A wait that a stop has cut has no timeout.
  const auto cuts = [&](const Sent& it) {
    return it.bus == sent.bus && (it.is_stop || it.is_failsafe) && it.begin < until;
  };
  if (std::none_of(ledger_.sent.begin() + id, ledger_.sent.end(), cuts)) {
    violation("heard_late", name(sent) + " left at " +
                                std::to_string(sent.heard.time_since_epoch() / 1us) + " us");
  }
}

// Of a drive whose slow registers may have been asked.
Duration Judge::longest_wait_of(std::size_t station) const {
  const drive::DeviceTiming& timing = plan_.timing_of(plan_.stations[station]);
  const drive::Device* device = plan_.device_of(plan_.stations[station]);
  Duration longest = timing.response_timeout;
  for (std::size_t at = 0; device != nullptr && at < device->profile.slow.size(); ++at) {
    longest = std::max(longest, device->profile.slow[at].response_timeout);
  }
  return longest + timing.response_wait;
}

}  // namespace mbgate::judge
