// SPDX-License-Identifier: Apache-2.0
// Connections beyond their limits, turns, and requests that are sent once for several clients.
#include <algorithm>
#include <map>
#include <numeric>

#include "judge/drill.hpp"
#include "report/findings/diagnosis.hpp"

namespace mbgate::judge {
namespace {

constexpr Duration kMoment = 10ms;

template <typename News>
std::size_t count_of(Drill& drill) {
  const auto is_one = [](const gateway::Event& it) { return std::holds_alternative<News>(it); };
  return static_cast<std::size_t>(std::ranges::count_if(drill.world().events(), is_one));
}

std::uint64_t sum_of(const bus::Histogram& histogram) {
  const auto counts = histogram.counts();
  return std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
}

std::size_t connections(Drill& drill) {
  return drill.world().gateway().report_status(0s, drill.now()).listeners.front().connections;
}

}  // namespace

// Who has the most connections loses one: one that never asked, then the longest idle.
void drill_room(Drill& drill, bool trace) {
  const auto most = drill.random().between<std::size_t>(4, 7);
  auto& listener = drill.plan().settings.listeners.front();
  listener.max_connections = most;
  drill.begin(trace);
  std::vector<Client*> greedy;
  for (std::size_t at = 0; at + 1 < most; ++at) {
    greedy.push_back(&drill.visit(0));
  }
  const std::size_t silent = drill.random().below(greedy.size());
  for (std::size_t at = 0; at < greedy.size(); ++at) {
    if (at != silent) {
      drill.read(*greedy[at], 0, 100ms);
    }
  }
  Client& modest = drill.visit(1);
  drill.wait(kMoment);
  drill.equal("connections", connections(drill), most);
  Client& newcomer = drill.visit(2);
  drill.wait(kMoment);
  drill.equal("connections", connections(drill), most);
  drill.expect("newcomer", newcomer.is_connected() && modest.is_connected());
  drill.expect("never_asked", !greedy[silent]->is_connected());
  Client& next = drill.visit(3);
  drill.wait(kMoment);
  const std::size_t oldest = silent == 0 ? 1 : 0;
  drill.expect("longest_idle", next.is_connected() && !greedy[oldest]->is_connected());
  drill.equal("displaced", count_of<gateway::ClientDisplaced>(drill), std::size_t{2});
  drill.equal("refused", count_of<gateway::ClientRefused>(drill), std::size_t{0});
  for (Client* it : {&modest, &newcomer, &next}) {
    if (it->is_connected()) {
      drill.read(*it, 0, 100ms);
    }
  }
  // Of a host that has the most, it is one of its own.
  const auto left = [&] {
    return std::ranges::count_if(greedy, [](const Client* it) { return it->is_connected(); });
  };
  const auto before = left();
  drill.visit(0);
  drill.wait(kMoment);
  drill.expect("own", modest.is_connected() && newcomer.is_connected() && next.is_connected());
  drill.equal("own_left", left(), before - 1);
}

// Clients take turns by their weights, however much they ask; of one connection in order.
void drill_turns(Drill& drill, bool trace) {
  const unsigned weight = drill.random().between(1U, 4U);
  auto& settings = drill.plan().settings;
  settings.weights.push_back({network_of(1), weight});
  settings.buses.front().coalesce = false;
  drill.begin(trace);
  std::vector<Client*> clients{&drill.visit(0), &drill.visit(0), &drill.visit(1), &drill.visit(2)};
  constexpr unsigned kEach = 12;
  for (Client* client : clients) {
    for (unsigned count = 1; count <= kEach; ++count) {
      drill.read(*client, 0, 0ms, count);
    }
  }
  drill.wait(20s);
  std::map<Id, unsigned> done;
  std::vector<const Asked*> order;
  for (Id id = 0; id < drill.ledger().asked.size(); ++id) {
    order.push_back(&drill.ledger().asked[id]);
    drill.expect("answered", drill.outcome(id) == "ok", drill.outcome(id));
    drill.expect("in_order", order.back()->intent.reads->count == ++done[order.back()->connection]);
  }
  // Until the host of weight has no more: where others have one turn, it has so many.
  std::map<unsigned, unsigned> got;
  std::ranges::sort(order, {}, &Asked::answered);
  for (auto it = order.begin(); got[1] < kEach && it != order.end(); ++it) {
    ++got[drill.ledger().connections[(*it)->connection].host];
  }
  const unsigned least = kEach / weight;
  const bool is_fair =
      got[0] + 2 >= least && got[0] <= least + 3 && got[2] + 2 >= least && got[2] <= least + 3;
  drill.expect("shares", is_fair,
               std::to_string(got[0]) + ", " + std::to_string(got[1]) + " and " +
                   std::to_string(got[2]) + " with weight " + std::to_string(weight));
  drill.equal("waits_noted", sum_of(drill.device(0).times.queue.all()),
              std::uint64_t{clients.size() * kEach});
  drill.equal("waiting", drill.bus().waiting, std::size_t{0});
}

// A read that waits is sent once for all who ask the same. What was read is kept for its age, until
// something is written.
void drill_sharing(Drill& drill, bool trace) {
  const Duration age = drill.random().duration(250ms, 500ms);
  drill.plan().settings.devices[1].cache = age;
  drill.plan().settings.buses.front().queue = 4;
  drill.timing(0).gap = drill.timing(1).gap = 0ms;
  drill.begin(trace);
  std::vector<Client*> clients;
  for (unsigned host = 0; host < 4; ++host) {
    clients.push_back(&drill.visit(host));
  }
  const auto read_all = [&](std::size_t station, unsigned count) {
    std::ranges::for_each(clients, [&](Client* it) { drill.read(*it, station, 0ms, count); });
  };
  drill.read(*clients[0], 0, 1ms, 1);  // on the wire
  read_all(0, 2);
  drill.wait(1s);
  drill.equal("shared", drill.transmissions().size(), std::size_t{2});
  drill.equal("shared_reads", drill.bus().counters.shared_reads, std::uint64_t{3});
  drill.read(*clients[0], 1, 90ms, 3);
  drill.read(*clients[1], 1, 0ms, 3);
  drill.wait(age);
  drill.equal("kept", drill.transmissions().size(), std::size_t{1});
  drill.equal("cached_reads", drill.bus().counters.cached_reads, std::uint64_t{1});
  drill.read(*clients[1], 1, 90ms, 3);
  drill.equal("too_old", drill.transmissions().size(), std::size_t{1});
  drill.write(*clients[0], 1, 90ms);
  drill.read(*clients[1], 1, 90ms, 3);
  drill.equal("after_a_write", drill.transmissions().size(), std::size_t{2});
  // Five wait where four have room: the newest read of who has the most gets 06.
  drill.wait(1s);
  drill.transmissions();
  drill.read(*clients[0], 0, 1ms, 1);
  std::vector<Id> asked;
  for (unsigned count = 2; count < 6; ++count) {
    asked.push_back(drill.read(*clients[0], 0, 0ms, count));
  }
  asked.push_back(drill.read(*clients[1], 0, 1s, 9));
  drill.expect("evicted", drill.outcome(asked[3]) == "06", drill.outcome(asked[3]));
  drill.equal("evictions", drill.bus().counters.evicted, std::uint64_t{1});
}

// Clients poll drives that are well: nothing is wrong, nothing is told, and all figures fit.
void drill_quiet(Drill& drill, bool trace) {
  drill.plan().settings.audit = true;
  drill.begin(trace);
  Client& client = drill.visit(0);
  constexpr unsigned kPolls = 10;
  for (unsigned poll = 0; poll < kPolls; ++poll) {
    for (const std::size_t at : {0U, 1U}) {
      const Id read = drill.read(client, at, 200ms);
      const Id written = drill.write(client, at, 200ms);
      drill.expect("answered", drill.outcome(read) == "ok" && drill.outcome(written) == "ok");
    }
    drill.wait(drill.random().duration(0ms, 1s));
  }
  const auto status = drill.world().gateway().report_status(10s, drill.now());
  for (const report::Diagnosis& it : report::diagnose(status)) {
    drill.expect("finding", false, it.subject + ": " + it.finding);
  }
  drill.equal("audited", count_of<gateway::WriteAccepted>(drill), std::size_t{2 * kPolls});
  drill.equal("events", drill.world().events().size(), 2 * kPolls + std::size_t{1});
  const gateway::BusStatus& bus = status.buses.front();
  drill.equal("silences", sum_of(bus.silences), std::uint64_t{4 * kPolls});
  drill.equal("responses", bus.counters.responses, std::uint64_t{4 * kPolls});
  drill.expect("no_faults", bus.counters.timeouts + bus.counters.bad_crcs +
                                    bus.counters.late_responses + bus.counters.unsolicited_frames +
                                    bus.counters.losses + bus.counters.expired ==
                                0);
  drill.expect("load", bus.load > 0 && bus.load < 100 && bus.busy < drill.now().time_since_epoch());
  for (const std::size_t at : {0U, 1U}) {
    const gateway::DeviceStatus& device = status.devices[at];
    Duration longest{0};
    for (const Sent& sent : drill.ledger().sent) {
      longest = sent.station == at ? std::max(longest, sent.answered - sent.end) : longest;
    }
    drill.equal("times", sum_of(device.times.device.all()), std::uint64_t{2 * kPolls});
    const bus::Durations& answers = device.times.device.lately();
    const auto wire = device.times.wire.lately().percentile(50);
    drill.between("p99", answers.percentile(99).value_or(0ms), 200us, 2 * longest + 1ms);
    drill.expect("p50", answers.percentile(50) &&
                            answers.percentile(50) <= answers.percentile(99) && wire > 0ms);
    drill.expect("quality", device.quality.quality == bus::Quality::good);
    drill.equal("unanswered_in_row", device.unanswered_in_row, 0U);
  }
  drill.equal("requests", status.listeners.front().counters.requests, std::uint64_t{4 * kPolls});
  drill.equal("clients", status.clients.size(), std::size_t{1});
  drill.equal("outstanding", status.clients.front().outstanding, std::size_t{0});
  drill.expect("address", status.clients.front().address == text_of(0));
  drill.equal("own_requests", unsigned{word_at(drill.own(client, request(8, 0x0E, 0)), 3)}, 1U);
}

}  // namespace mbgate::judge
