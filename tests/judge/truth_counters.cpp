// SPDX-License-Identifier: Apache-2.0
// When faults have stopped, the gateway's own counters say what the ledger has counted, as far as
// it is certain from outside.
#include <algorithm>

#include "judge/rules_judge.hpp"

namespace mbgate::judge {

void RulesJudge::compare(const std::string& what, std::uint64_t shown, Bounds seen) {
  if (shown < seen.least || shown > seen.most) {
    report_.violation("counter", what + " " + std::to_string(shown) + ", seen " +
                                     std::to_string(seen.least) + " to " +
                                     std::to_string(seen.most));
  }
}

void RulesJudge::check_counters() {
  check_refused_writes();
  const auto status = world_.gateway().report_status(0s, world_.now());
  // A bus that a reload has replaced counts anew.
  const bool is_replaced =
      report_.faults.contains("bus_renamed") || report_.faults.contains("low_latency_changed");
  for (std::size_t at = 0; at < plan_.lines.size() && !is_replaced; ++at) {
    for (const auto& bus : status.buses) {
      if (bus.name == plan_.bus(at).name) {
        check_bus(at, bus);
      }
    }
  }
  for (const auto& device : status.devices) {
    if (is_replaced) {
      break;
    }
    for (std::size_t at = 0; at < plan_.stations.size(); ++at) {
      const Station& station = plan_.stations[at];
      if (plan_.bus(station.bus).name == status.buses[device.bus].name &&
          station.address == device.address) {
        const auto sent =
            static_cast<std::uint64_t>(std::ranges::count_if(ledger_.sent, [&](const Sent& it) {
              return it.process == ledger_.process && it.station == at;
            }));
        compare(device.name + ": transmissions", device.counters.transmissions, {sent, sent});
        compare(device.name + ": ends",
                device.counters.responses + device.counters.timeouts + device.counters.bad_crcs,
                {0, sent});
      }
    }
  }
  for (std::size_t at = 0; at < status.listeners.size(); ++at) {
    check_listener(at, status.listeners[at]);
  }
}

void RulesJudge::check_bus(std::size_t at, const gateway::BusStatus& bus) {
  std::uint64_t sent = 0;
  std::uint64_t broadcasts = 0;
  Bounds stops;
  for (const Sent& it : ledger_.sent) {
    if (it.process == ledger_.process && it.bus == at) {
      ++sent;
      broadcasts += it.is_broadcast ? 1U : 0U;
      stops.least += it.is_stop && !it.is_failsafe ? 1U : 0U;
      stops.most += it.is_stop || it.is_failsafe ? 1U : 0U;
    }
  }
  const auto& shown = bus.counters;
  compare(bus.name + ": transmissions", shown.transmissions, {sent, sent});
  compare(bus.name + ": broadcasts", shown.broadcasts, {broadcasts, broadcasts});
  compare(bus.name + ": stops", shown.stops, stops);
  compare(bus.name + ": ends", shown.responses + shown.timeouts + shown.bad_crcs,
          {0, sent - broadcasts});
  compare(bus.name + ": exceptions", shown.exceptions, {0, shown.responses});
}

// What was answered was counted; what its client did not wait for perhaps not.
void RulesJudge::check_listener(std::size_t at, const gateway::ListenerStatus& listener) {
  Bounds connections;
  Bounds requests;
  std::map<unsigned, Bounds> refused;
  std::set<Id> asking;
  for (const Asked& asked : ledger_.asked) {
    const Connection& connection = connection_of(asked);
    if (connection.listener != at || connection.process != ledger_.process ||
        asked.given == kNever) {
      continue;
    }
    requests.least += asked.answers > 0 ? 1U : 0U;
    ++requests.most;
    if (asked.answers == 0) {
      continue;
    }
    asking.insert(asked.connection);
    if (asked.answer.size() == 2 && asked.answer[0] >= 0x80) {
      const unsigned code = asked.answer[1];
      // Behind a server drives say such things too, and to whom is not always known.
      const bool is_own = asked.intent.station && asked.sent.empty() &&
                          !plan_.is_tcp(plan_.stations[*asked.intent.station].bus);
      refused[code].least += is_own ? 1U : 0U;
      ++refused[code].most;
    }
  }
  for (const Connection& connection : ledger_.connections) {
    connections.most +=
        connection.listener == at && connection.process == ledger_.process ? 1U : 0U;
  }
  connections.least = asking.size();
  const auto& shown = listener.counters;
  compare(listener.name + ": connections", shown.connections, connections);
  compare(listener.name + ": requests", shown.requests, requests);
  const std::uint64_t unheard = requests.most - requests.least;
  for (const unsigned code : {1U, 2U, 3U, 6U, 10U, 11U}) {
    const std::uint8_t it = low(code);
    compare(listener.name + ": refused with " + std::to_string(code),
            shown.refused_reads.of(it) + shown.refused_writes.of(it),
            {refused[code].least, refused[code].most + unheard});
  }
}

}  // namespace mbgate::judge
