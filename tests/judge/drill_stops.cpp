// SPDX-License-Identifier: Apache-2.0
// Stops: how soon, how often, what they cancel, and what is said of those that fail.
#include <algorithm>

#include "judge/drills.hpp"

namespace mbgate::judge {

using namespace std::chrono_literals;
using Notice = bus::DeviceNotice::Kind;

namespace {
constexpr std::uint16_t kStopWord = 0x5001;
}  // namespace

// Next on its bus behind the running transaction, whatever waits; and writes to its drive that wait
// are cancelled.
void drill_stop_first(Drill& drill, bool trace) {
  drill.timing(0).gap = drill.timing(1).gap = 0ms;
  drill.begin(trace);
  Client& poller = drill.visit(0);
  Client& writer = drill.visit(1);
  Client& stopper = drill.visit(2);
  for (unsigned count = 1; count <= 10; ++count) {
    drill.read(poller, count % 2, 0ms, count);
  }
  drill.wait(1ms);
  const Id cancelled = drill.write(writer, 0);
  const Id other = drill.write(writer, 1);
  const std::size_t before = drill.transmissions().size();
  drill.expect("one_runs", before == 1, std::to_string(before));
  const Id stop = drill.stop(stopper, 0, kStopWord, 2s);
  const auto sent = drill.transmissions();
  drill.expect("stop_first", !sent.empty() && drill.ledger().sent[sent.front()].is_stop);
  const Sent& running = drill.ledger().sent.front();
  const Sent& first = drill.ledger().sent[1];
  drill.between("stop_soon", first.begin - running.answered, 0ms,
                silence_of(drill.plan().bus(0)) + 1ms);
  drill.expect("stopped", drill.outcome(stop) == "ok", drill.outcome(stop));
  drill.expect("cancelled", drill.outcome(cancelled) == "06", drill.outcome(cancelled));
  drill.expect("not_cancelled", drill.outcome(other) == "ok", drill.outcome(other));
  drill.equal("overtaken", drill.bus().counters.overtaken_writes, std::uint64_t{1});
  drill.equal("stops", drill.bus().counters.stops, std::uint64_t{1});
  // Identical ones that wait are sent once, for all of them.
  drill.wait(2s);
  drill.transmissions();
  drill.read(poller, 1, 1ms, 20);
  std::vector<Id> same;
  for (Client* client : {&poller, &writer, &stopper}) {
    same.push_back(drill.stop(*client, 0, kStopWord + 1));
  }
  drill.wait(500ms);
  drill.equal("sent_once", drill.transmissions().size(), std::size_t{2});
  for (const Id id : same) {
    drill.expect("all_stopped", drill.outcome(id) == "ok", drill.outcome(id));
  }
}

// Tried as often as it says, and told; then once, until the drive is heard.
void drill_stop_fails(Drill& drill, bool trace) {
  drive::DeviceTiming& timing = drill.timing(0);
  timing.offline_after = 1;
  drill.plan().settings.buses.front().hung_after = 0ms;
  drill.begin(trace);
  Client& client = drill.visit(0);
  drill.read(client, 0, 3s);
  const bool refuses = drill.random().chance(500);
  Habits& habits = drill.world().habits_of(0);
  (refuses ? habits.refuses_stops : habits.deaf) = 1000;
  drill.transmissions();
  const Id stop = drill.stop(client, 0, kStopWord, 10s);
  const auto tries = drill.transmissions();
  drill.equal("tries", tries.size(), std::size_t{1 + timing.stop_retries});
  const Octets said = drill.ledger().asked[stop].answer;
  drill.expect("failed", said.size() == 2 && said[0] == 0x86 && (refuses || said[1] == 0x0B));
  for (std::size_t at = 1; at < tries.size() && refuses; ++at) {
    drill.between(
        "between_tries",
        drill.ledger().sent[tries[at]].begin - drill.ledger().sent[tries[at - 1]].answered,
        drill.plan().bus(0).stop_wait, drill.plan().bus(0).stop_wait + 30ms);
  }
  drill.equal("told", drill.notices(refuses ? Notice::stop_refused : Notice::stop_unanswered, 0),
              std::size_t{1});
  drill.equal("unanswered", drill.bus().counters.stops_unanswered, std::uint64_t{1});
  const gateway::DeviceStatus device = drill.device(0);
  drill.expect("shown", device.last_failed_stop.has_value());
  drill.equal("exception", unsigned{device.stop_exception}, refuses ? unsigned{said[1]} : 0U);
  drill.expect("offline", refuses != (device.state == bus::DeviceState::offline));
  if (!refuses) {
    drill.stop(client, 0, kStopWord, 5s);
    drill.equal("once", drill.transmissions().size(), std::size_t{1});
  }
  habits.refuses_stops = habits.deaf = 0;
  drill.wait(3s);
  const Id well = drill.stop(client, 0, kStopWord + 1, 2s);
  drill.expect("well", drill.outcome(well) == "ok", drill.outcome(well));
}

// The echo of a stop by 16 that comes late does not acknowledge the next one, which looks alike.
void drill_old_echo(Drill& drill, bool trace) {
  drive::DeviceTiming& timing = drill.timing(0);
  timing.stop_retries = 0;
  timing.offline_after = 0;
  timing.quarantine = 60ms;
  drill.begin(trace);
  Client& client = drill.visit(0);
  Habits& habits = drill.world().habits_of(0);
  const auto stop = [&](unsigned word) {
    const Octets pdu{0x10, 0, kStopRegister, 0, 1, 2, 0x50, low(word)};
    const Id id = drill.ask(client, drill.intent(Kind::stop, 0, pdu), drill.longest(0));
    for (unsigned more = 0; more < 100 && drill.outcome(id).empty(); ++more) {
      drill.wait(1ms);
    }
    return id;
  };
  for (unsigned asked = 1; asked <= 8; ++asked) {
    habits.late = 1000;
    const Id late = stop(2 * asked);
    drill.expect("late", drill.outcome(late) == "0B", drill.outcome(late));
    habits.deaf = 1000;
    const Id unheard = stop(2 * asked + 1);
    drill.expect("unheard", drill.outcome(unheard) == "0B", drill.outcome(unheard));
    habits.late = habits.deaf = 0;
    drill.read(client, 0, 2s);
  }
}

}  // namespace mbgate::judge
