// SPDX-License-Identifier: Apache-2.0
// One transaction at a time on a line, with the silence that the standard requires (promise 1), and
// a drive that may still answer is left alone (promise 5; behaviour.md, sections 4 and 5).
#include <algorithm>

#include "judge/judge.hpp"

namespace mbgate::judge {

using namespace std::chrono_literals;

namespace {
// The gateway counts in the same nanoseconds; only the drivers' clocks differ.
constexpr Duration kRounding = 1us;
}  // namespace

void Judge::check_silence(Id id) {
  const Sent& sent = ledger_.sent[id];
  const LineBook& line = ledger_.lines[sent.bus];
  if (!line.open) {
    return;
  }
  if (plan_.is_tcp(sent.bus)) {
    return;
  }
  const auto& bus = plan_.bus(sent.bus);
  const Duration silence = bus.frame_gap.value_or(WireTimes(bus.line).silence());
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

// Where nothing at all came, an answer may still come until its timeout.
void Judge::check_waiting(Id id) {
  const Sent& sent = ledger_.sent[id];
  const LineBook& line = ledger_.lines[sent.bus];
  if (plan_.is_tcp(sent.bus) || line.last == kNone || !line.open) {
    return;
  }
  const Sent& before = ledger_.sent[line.last];
  if (sent.is_stop || sent.is_failsafe) {
    return;
  }
  if (!before.expects_answer || !before.station || line.heard >= before.begin ||
      ledger_.reloaded >= before.begin || before.opening != line.openings) {
    return;
  }
  const drive::DeviceTiming& timing = plan_.timing_of(plan_.stations[*before.station]);
  const Duration least = std::min(timing.response_timeout, timing.probe_timeout_or_default());
  const bool is_stop = before.is_stop || before.is_failsafe;
  const Duration limit =
      is_stop ? std::min(plan_.bus(sent.bus).stop_wait, least) : timing.response_wait + least;
  if (sent.begin + kRounding < before.end + limit) {
    violation("impatient", name(sent) + " behind " + name(before) + ", after " +
                               std::to_string((sent.begin - before.end) / 1us) + " us, not " +
                               std::to_string(limit / 1us));
  }
}

void Judge::check_hold(Id id) {
  const Sent& sent = ledger_.sent[id];
  if (!sent.station || sent.is_stop || sent.is_failsafe || plan_.is_tcp(sent.bus)) {
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
    const Instant until = before.end +
                          std::min(timing.response_timeout, timing.probe_timeout_or_default()) +
                          timing.response_wait + timing.quarantine_or_default();
    if (sent.begin + kRounding < until) {
      violation("hold", name(sent) + " behind " + name(before));
      return;
    }
  }
}

}  // namespace mbgate::judge
