// SPDX-License-Identifier: Apache-2.0
// A stop is on the wire within its bound, and repeated while its drive says "not now".
#include <algorithm>

#include "judge/judge.hpp"

namespace mbgate::judge {

// A stop to a drive that has not answered the last one, nor anything since, may wait while lost
// time is paid back to others, as often as they lose more.
bool Judge::follows_silence(const Sent& stop, Id id) const {
  const auto& all = ledger_.last_sent[*stop.station];
  const auto last = std::find_if(all.rbegin(), all.rend(), [&](Id it) {
    return it != id && (ledger_.sent[it].is_stop || ledger_.sent[it].answered != kNever);
  });
  return last != all.rend() && ledger_.sent[*last].answered == kNever;
}

// From acceptance, or from when its line was there, to the wire; others that wait are counted.
void Judge::check_stop_time(Id id) {
  const Sent& sent = ledger_.sent[id];
  const LineBook& line = ledger_.lines[sent.bus];
  if (!sent.is_stop || sent.asked.empty()) {
    return;
  }
  const Asked& asked = ledger_.asked[sent.asked.front()];
  if (asked.sent.size() > 1 || asked.intent.kind != Kind::stop ||
      asked.intent.sent.empty() == asked.intent.whole || follows_silence(sent, id)) {
    return;
  }
  const Instant from = std::max({asked.given, line.opened, ledger_.reloaded});
  Duration longest = 0ms;
  for (const drive::Device& device : plan_.settings.devices) {
    longest = std::max(longest, device.timing.response_timeout + device.timing.response_wait);
  }
  unsigned others = 0;  // stops that went meanwhile, each with its tries
  for (Id before = id; before > 0 && ledger_.sent[before - 1].begin >= from; --before) {
    others += ledger_.sent[before - 1].bus == sent.bus ? 1U : 0U;
  }
  const Duration frame = 2 * WireTimes(plan_.bus(sent.bus).line).of(kAsciiFrame);
  const Duration stopped = plan_.driver.stops ? 5s : 0s;  // the process, several times
  const Duration bound = 2s + 600ms + stopped + frame + (others + 1) * (longest + frame / 4);
  if (sent.begin > from + bound && !is_overfull(asked.connection, asked.given)) {
    violation("stop_late", name(sent) + " for " + name(asked) + ", after " +
                               std::to_string((sent.begin - from) / 1ms) + " ms");
  }
}

// Where its drive has answered each try with "not now", it was tried often enough.
void Judge::check_refused_stop(const Asked& asked) {
  constexpr std::uint32_t kTryAgain = code(5) | code(6) | code(10) | code(11);
  if (asked.intent.kind != Kind::stop || asked.sent.empty() || asked.answer[0] < 0x80 ||
      (kTryAgain >> asked.answer[1] & 1U) == 0 || ledger_.reloaded >= asked.given ||
      ledger_.stopping != kNever || plan_.has_failsafe(plan_.stations[*asked.intent.station])) {
    return;
  }
  const bool is_refused = std::ranges::all_of(asked.sent, [&](Id id) {
    const Sent& sent = ledger_.sent[id];
    const std::uint32_t said = sent.exceptions;
    return said != 0 && (said & ~kTryAgain) == 0 &&
           sent.answered < sent.end + longest_wait_of(*asked.intent.station) &&
           ledger_.lines[sent.bus].open && sent.opening == ledger_.lines[sent.bus].openings;
  });
  const drive::DeviceTiming& timing = plan_.timing_of(plan_.stations[*asked.intent.station]);
  // After a whole series that failed, a stop is one try until the drive is heard.
  const auto& stops = ledger_.stops[*asked.intent.station];
  const bool is_first = std::ranges::none_of(stops, [&](Id id) {
    const Asked& other = ledger_.asked[id];
    return &other != &asked && other.given <= now();
  });
  if (is_refused && is_first && asked.sent.size() < 1 + timing.stop_retries) {
    violation("stop_given_up",
              name(asked) + ", after " + std::to_string(asked.sent.size()) + " tries");
  }
}

}  // namespace mbgate::judge
