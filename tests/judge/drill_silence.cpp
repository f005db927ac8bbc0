// SPDX-License-Identifier: Apache-2.0
// A drive loses its supply, and gets it back.
#include "judge/drills.hpp"

namespace mbgate::judge {

using namespace std::chrono_literals;
using Notice = bus::DeviceNotice::Kind;

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

}  // namespace mbgate::judge
