// SPDX-License-Identifier: Apache-2.0
// A drive loses its supply, and gets it back. Stops: how soon, how often, what they cancel, and
// what is said of those that fail.
#include <algorithm>

#include "judge/drill.hpp"

namespace mbgate::judge {

using Notice = bus::DeviceNotice::Kind;

namespace {
constexpr std::uint16_t kStopWord = 0x5001;
}  // namespace

void drill_silence(Drill& drill, bool trace) {
  drive::DeviceTiming& timing = drill.timing(0);
  timing.offline_after = drill.random().between(1U, 4U);
  drill.begin(trace);
  Client& client = drill.visit(0);
  drill.read(client, 1, 3s);  // what it is paid back is forgotten by then
  const Id first = drill.read(client, 0, 1s);
  drill.equal("transmissions", drill.transmissions().size(), std::size_t{2});
  drill.expect("answered", drill.outcome(first) == "ok");
  gateway::DeviceStatus device = drill.device(0);
  drill.expect("state", device.state == bus::DeviceState::answering && device.has_answered);
  const Sent sent = drill.ledger().sent.back();
  drill.between("last_answer", device.last_answer.value_or(0s), drill.now() - sent.answered - 2ms,
                drill.now() - sent.answered);
  drill.between("last_request", device.last_request.value_or(0s), drill.now() - sent.begin,
                drill.now() - sent.begin);
  drill.world().habits_of(0).dead = true;
  const unsigned tries = std::min(1 + timing.retries, timing.offline_after);
  unsigned in_row = 0;
  while (in_row < timing.offline_after) {
    const Instant begun = drill.now();
    const Id asked = drill.read(client, 0, 5s);
    const auto tried = drill.transmissions();
    const unsigned most = std::min(tries, timing.offline_after - in_row);
    drill.equal("tries", tried.size(), std::size_t{most});
    in_row += most;
    drill.expect("outcome", drill.outcome(asked) == "0B", drill.outcome(asked));
    if (tried.empty()) {
      return;
    }
    const Duration took = drill.ledger().asked[asked].answered - begun;
    drill.between("patience", took, most * drill.longest(0), most * (drill.longest(0) + 40ms));
    device = drill.device(0);
    drill.equal("unanswered_in_row", device.unanswered_in_row, in_row);
    drill.equal("silent_transmissions", device.silence.transmissions(), in_row);
    const Instant since = drill.ledger().sent[2].begin;
    drill.between("silent_for", device.silent_for, drill.now() - since, drill.now() - since);
    drill.expect("state",
                 device.state == (in_row < timing.offline_after ? bus::DeviceState::not_answering
                                                                : bus::DeviceState::offline));
  }
  drill.equal("timeouts", device.counters.timeouts, std::uint64_t{in_row});
  drill.equal("lost", drill.notices(Notice::lost, 0), std::size_t{1});
  // Its probe is due: the request is the probe, once; then others get 0B and 06 at once.
  const Id probe = drill.read(client, 0, timing.probe_interval / 2);
  const auto probed = drill.transmissions();
  drill.equal("probes", probed.size(), std::size_t{1});
  drill.equal("probes_counted", drill.bus().counters.probes, std::uint64_t{1});
  drill.expect("probe_answered", drill.outcome(probe) == "0B", drill.outcome(probe));
  const Id refused = drill.read(client, 0, 10ms);
  const Id written = drill.write(client, 0, 10ms);
  drill.expect("read_refused", drill.outcome(refused) == "0B", drill.outcome(refused));
  drill.expect("write_refused", drill.outcome(written) == "06", drill.outcome(written));
  drill.equal("refused_offline", drill.bus().counters.refused_offline, std::uint64_t{2});
  drill.equal("sent_offline", drill.transmissions().size(), std::size_t{0});
  drill.expect("next_probe",
               drill.device(0).next_probe && *drill.device(0).next_probe <= timing.probe_interval);
  const auto shown = [&] {  // its state, and whether it is offline (mbgated(8))
    const Octets answer = drill.own(client, request(4, 10000, 19));
    return answer.size() == 40 ? word_at(answer, 6) * 10U + word_at(answer, 38) : 0U;
  };
  drill.equal("own_unit", shown(), 31U);
  drill.world().habits_of(0).dead = false;
  drill.wait(timing.probe_interval + 3s);
  const Id back = drill.read(client, 0, 3s);
  drill.expect("back_answered", drill.outcome(back) == "ok", drill.outcome(back));
  drill.equal("own_unit", shown(), 10U);
  drill.equal("back", drill.notices(Notice::back, 0), std::size_t{1});
  device = drill.device(0);
  drill.expect("state", device.state == bus::DeviceState::answering &&
                            device.unanswered_in_row == 0 && device.silence.transmissions() == 0);
  drill.equal("responses", device.counters.responses, std::uint64_t{2});
}

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
