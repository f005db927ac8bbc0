// SPDX-License-Identifier: Apache-2.0
// What stands around answers and inside them, and does not keep them from their clients; and frames
// of others.
#include <algorithm>

#include "judge/drill.hpp"

namespace mbgate::judge {

// Bytes in front and behind, pauses shorter than `frame_slack`: each read is answered at once.
void drill_noise(Drill& drill, bool trace) {
  constexpr unsigned kAsked = 12;
  drill.begin(trace);
  Client& client = drill.visit(0);
  Habits& habits = drill.world().habits_of(0);
  habits.most_glitches = 7;  // eight are as long as the request
  std::uint64_t answered = 0;
  const std::array<unsigned Habits::*, 3> all{&Habits::glitches, &Habits::tails, &Habits::pauses};
  for (unsigned Habits::*const habit : all) {
    habits.*habit = 1000;
    for (unsigned asked = 0; asked < kAsked; ++asked) {
      const Id id = drill.read(client, 0, 500ms, asked + 1);
      answered += drill.outcome(id) == "ok" ? 1U : 0U;
    }
    habits.*habit = 0;
  }
  const gateway::DeviceStatus device = drill.device(0);
  if (answered == 3 * kAsked - 1) {
    ++drill.world().report().apart["check_by_chance"];  // with noise inside
    return;
  }
  drill.equal("answered_in_noise", answered, std::uint64_t{3} * kAsked);
  drill.expect("sent_once", drill.transmissions().size() <= 3 * kAsked + 1);  // a frame by chance
  drill.equal("responses", device.counters.responses, std::uint64_t{3} * kAsked);
  drill.equal("lost", drill.notices(bus::DeviceNotice::Kind::lost, 0), std::size_t{0});
  drill.expect("well", device.quality.quality == bus::Quality::good);
  const bool has_glitches = drill.plan().bus(0).line.framing == bus::Framing::rtu;
  const bus::BusCounters line = drill.bus().counters;
  const bool is_seen = line.noise_bytes > 0 || (has_glitches && line.stray_bytes > 0);
  drill.expect("noise_counted", has_glitches == is_seen);
  drill.equal("noise_of_device", device.counters.noise_bytes > 0, line.noise_bytes > 0);
}

// The others on the line do not wait longer for an answer that has begun than for its wire time and
// 1 s, however slowly its bytes come.
void drill_crawl(Drill& drill, bool trace) {
  drill.timing(0).retries = 0;
  drill.begin(trace);
  Client& crawled = drill.visit(0);
  Client& other = drill.visit(1);
  drill.world().habits_of(0).crawls = 1000;
  for (unsigned asked = 0; asked < 3; ++asked) {
    drill.transmissions();
    drill.read(crawled, 0, 10ms);
    drill.read(other, 1, 40s);
    const auto sent = drill.transmissions();
    drill.expect("sent_behind_a_crawl", sent.size() > 1);
    const Sent& first = drill.ledger().sent[sent.front()];
    const Instant begun = first.crawls == kNever ? first.end : first.crawls;
    drill.between("held_by_a_crawl", drill.ledger().sent[sent.back()].begin - begun, 0ms,
                  WireTimes(drill.plan().bus(0).line).of(kAsciiFrame) + 1s + 150ms);
  }
}

// Good frames that do not fit end the wait, and are told; the drive is there.
void drill_misfits(Drill& drill, bool trace) {
  drive::DeviceTiming& timing = drill.timing(0);
  timing.offline_after = 1;
  timing.response_timeout = 120ms;
  drill.begin(trace);
  Client& client = drill.visit(0);
  drill.read(client, 0, 1s);
  drill.world().habits_of(0).misfits = 1000;
  bool was_told = false;
  for (unsigned asked = 0; asked < 6; ++asked) {
    drill.transmissions();
    const Id id = drill.write(client, 0, 3s);
    drill.expect("uncertain", drill.outcome(id) == "0B", drill.outcome(id));
    const Sent& sent = drill.ledger().sent[drill.transmissions().front()];
    const auto& came = drill.ledger().lines[0].came.back();
    const Duration waited = drill.ledger().asked[id].answered - came.at;
    if (came.ends_wait) {
      drill.between("waited", waited, 0ms, slack_of(drill.plan().bus(0)) + 2ms);
      was_told = true;
    }
    drill.expect("ended", drill.ledger().asked[id].answered <=
                              sent.end + timing.response_wait + timing.response_timeout + 60ms);
  }
  drill.equal("misfit_told", drill.notices(bus::DeviceNotice::Kind::misfit, 0),
              std::size_t{was_told ? 1U : 0U});
}

// A drive of another client's on the line: told once, and nobody's answer.
void drill_stranger(Drill& drill, bool trace) {
  drill.plan().lines[0].stranger_every = 2s;
  drill.timing(0).quarantine_max = drill.timing(1).quarantine_max = 1s;
  drill.begin(trace);
  Client& client = drill.visit(0);
  for (unsigned asked = 0; asked < 20; ++asked) {
    const Id id = drill.read(client, asked % 2, 1s);
    drill.expect("answered", drill.outcome(id) == "ok" || drill.outcome(id) == "0B");
  }
  drill.wait(60s);
  const auto told = std::ranges::count_if(drill.world().events(), [](const gateway::Event& event) {
    const auto* news = std::get_if<gateway::DeviceNews>(&event);
    return news != nullptr && news->notice.kind == bus::DeviceNotice::Kind::foreign;
  });
  drill.equal("foreign_told", told, std::ptrdiff_t{1});
  const std::uint64_t counted = drill.bus().counters.foreign_frames;
  drill.expect("foreign_counted", counted > 30, std::to_string(counted));
}

}  // namespace mbgate::judge
