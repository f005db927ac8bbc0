// SPDX-License-Identifier: Apache-2.0
// Answers with bad checks, late ones, and second ones.
#include <algorithm>

#include "judge/drill.hpp"

namespace mbgate::judge {

using bus::Quality;

namespace {

constexpr Duration kSoon = 3ms;  // a process that is never late does what is due

std::size_t news_of(Drill& drill, Quality quality, std::optional<std::uint8_t> address) {
  const auto& events = drill.world().events();
  return static_cast<std::size_t>(std::ranges::count_if(events, [&](const gateway::Event& event) {
    const auto* news = std::get_if<gateway::QualityNews>(&event);
    return news != nullptr && news->notice.address == address &&
           news->notice.verdict.quality == quality;
  }));
}

}  // namespace

// Whatever its check, a frame is a sign of life: nobody is called silent.
void drill_damage(Drill& drill, bool trace) {
  constexpr unsigned kAsked = 6;
  drill.timing(0).offline_after = drill.timing(1).offline_after = 2;
  drill.begin(trace);
  Client& client = drill.visit(0);
  for (const std::size_t at : {0U, 1U}) {
    const drive::DeviceTiming& timing = drill.timing(at);
    drill.read(client, at, 1s);
    drill.transmissions();
    Habits& habits = drill.world().habits_of(at);
    habits.damaged = 1000;
    habits.damages_check = true;
    unsigned bad = 0;
    for (unsigned asked = 0; asked < kAsked; ++asked) {
      const Id id = drill.read(client, at, 2s);
      const std::size_t tries = drill.transmissions().size();
      bad += static_cast<unsigned>(tries);
      drill.equal("tries", tries, std::size_t{1 + timing.retries});
      drill.expect("damaged", drill.outcome(id) == "0B", drill.outcome(id));
    }
    habits.damaged = 0;
    const gateway::DeviceStatus device = drill.device(at);
    const std::uint8_t address = device.address;
    if (device.counters.bad_crcs + 1 == bad && device.counters.timeouts == 1) {
      ++drill.world().report().apart["check_by_chance"];  // of two damaged answers together
      return;
    }
    drill.equal("bad_crcs", device.counters.bad_crcs, std::uint64_t{bad});
    drill.equal("timeouts", device.counters.timeouts, std::uint64_t{0});
    drill.equal("responses", device.counters.responses, std::uint64_t{1});
    drill.equal("lost", drill.notices(bus::DeviceNotice::Kind::lost, at), std::size_t{0});
    drill.equal("verdict", static_cast<int>(device.quality.quality),
                static_cast<int>(Quality::bad_crc));
    drill.equal("verdict_of", device.quality.of, bad + 1);
    drill.equal("verdict_count", device.quality.count, bad);
    drill.equal("told", news_of(drill, Quality::bad_crc, address), std::size_t{1});
    drill.equal("line_told", news_of(drill, Quality::bad_crc, std::nullopt), at);
    const Id well = drill.read(client, at, 1s);
    drill.expect("well", drill.outcome(well) == "ok", drill.outcome(well));
  }
  drill.equal("bus_retries", drill.bus().counters.retries,
              std::uint64_t{kAsked} * (drill.timing(0).retries + drill.timing(1).retries));
}

// What comes late is told with its figures, and the drive gets the time that it needs.
void drill_lateness(Drill& drill, bool trace) {
  constexpr unsigned kAsked = 6;
  drive::DeviceTiming& timing = drill.timing(0);
  timing.offline_after = 0;
  timing.retries = 0;
  timing.quarantine = drill.random().duration(100ms, 300ms);
  drill.begin(trace);
  Client& client = drill.visit(0);
  drill.read(client, 0, 1s);
  const auto lateness = [&] {
    const Sent& sent = drill.ledger().sent.back();
    return sent.answered - sent.end - timing.response_timeout - timing.response_wait;
  };
  drill.world().habits_of(0).late = 1000;
  Duration most{0};
  for (unsigned asked = 0; asked < kAsked; ++asked) {
    const Id id = drill.read(client, 0, 2s);
    drill.expect("late", drill.outcome(id) == "0B", drill.outcome(id));
    most = std::max(most, lateness());
  }
  gateway::DeviceStatus device = drill.device(0);
  drill.equal("late_responses", device.counters.late_responses, std::uint64_t{kAsked});
  drill.equal("timeouts", device.counters.timeouts, std::uint64_t{kAsked});
  drill.equal("verdict", static_cast<int>(device.quality.quality), static_cast<int>(Quality::late));
  drill.equal("verdict_count", device.quality.count, kAsked);
  drill.between("lateness", device.quality.lateness, most - kSoon, most + kSoon);
  drill.between("needed", device.quality.needed, timing.response_timeout + most,
                timing.response_timeout + 2 * most + 20ms);
  drill.equal("told", news_of(drill, Quality::late, device.address), std::size_t{1});
  drill.equal("silent", device.silence.transmissions(), 0U);
  drill.world().habits_of(0).late = 0;
  drill.world().habits_of(0).very_late = 1000;
  drill.read(client, 0, 3s);
  most = lateness();
  device = drill.device(0);
  drill.expect("grew", drill.notices(bus::DeviceNotice::Kind::late, 0) > 0);
  drill.between("quarantine", device.quarantine, most * 9 / 10,
                std::max(2 * most, *timing.quarantine) + 40ms);
}

// While an answer may still come, the drive is left alone; and no longer.
void drill_hold(Drill& drill, bool trace) {
  drive::DeviceTiming& timing = drill.timing(0);
  timing.offline_after = 0;
  timing.retries = 0;
  timing.gap = 0ms;
  timing.quarantine = drill.random().duration(50ms, 300ms);
  drill.plan().settings.listeners[0].idle_timeout = 3s;
  drill.begin(trace);
  Client& client = drill.visit(0);
  drill.world().habits_of(0).dead = true;
  drill.read(client, 0, 25ms, 4);
  drill.world().habits_of(0).dead = false;
  drill.wait(drill.longest(0));
  drill.expect("held_back", drill.device(0).held_back > 0ms);
  const Id next = drill.read(client, 0, 2s, 5);
  drill.equal("transmissions", drill.transmissions().size(), std::size_t{2});
  const Sent first = drill.ledger().sent[0];
  const Instant due = first.end + timing.response_wait + timing.response_timeout;
  const Duration until = *timing.quarantine + 20ms;  // an adapter may keep it
  drill.between("held", drill.ledger().sent[1].begin - due, until, until + kSoon);
  drill.expect("answered", drill.outcome(next) == "ok", drill.outcome(next));
  drill.read(client, 0, 1ms, 6);
  drill.read(client, 0, 1s, 7);
  const Sent& before = drill.ledger().sent[2];
  drill.between("not_held", drill.ledger().sent[3].begin - before.answered, 0ms,
                silence_of(drill.plan().bus(0)) + drill.plan().bus(0).settle + 40ms);
  drill.wait(4s);
  drill.expect("idle_closed", !client.is_connected());
}

// A drive that answers twice is left alone behind each answer for as long as it needs.
void drill_seconds(Drill& drill, bool trace) {
  constexpr unsigned kAsked = 12;
  constexpr std::size_t kSure = 3;
  drive::DeviceTiming& timing = drill.timing(0);
  timing.gap = 0ms;
  timing.quarantine_max = 30s;
  timing.response_timeout = 120ms;
  Habits& planned = drill.plan().drives[0].habits;
  planned.second = 1000;
  planned.second_from = planned.second_to = drill.random().duration(2ms, 20ms);
  drill.begin(trace);
  Client& client = drill.visit(0);
  for (std::size_t asked = 1; asked <= kAsked; ++asked) {
    const Id id = drill.read(client, 0, 1s);
    drill.expect("answered", drill.outcome(id) == "ok", drill.outcome(id));
    drill.equal("told", drill.notices(bus::DeviceNotice::Kind::second_answer, 0),
                std::size_t{asked >= kSure ? 1U : 0U});
  }
  const Came second = drill.ledger().lines[0].came.back();
  const Sent& last = drill.ledger().sent.back();
  const auto ago = drill.device(0).last_second_answer;
  if (!drill.plan().lines[0].echoes) {
    drill.expect("seen", ago.has_value());
    drill.between("ago", ago.value_or(0ms), drill.now() - second.at, drill.now() - second.at);
  }
  const Duration after = second.at - last.answered;
  drill.transmissions();
  drill.read(client, 0, 1ms, 5);
  drill.read(client, 0, 1s, 6);
  const auto sent = drill.transmissions();
  drill.equal("transmissions", sent.size(), std::size_t{2});
  const Duration held = drill.ledger().sent[sent[1]].begin - drill.ledger().sent[sent[0]].answered;
  const Duration least = std::min<Duration>(after, timing.response_timeout);
  drill.between("held", held, least, after * 5 / 4 + 35ms + drill.plan().bus(0).settle);
}

}  // namespace mbgate::judge
