// SPDX-License-Identifier: Apache-2.0
// What is wrong with a bus.
#include <algorithm>
#include <utility>

#include "gateway/status/findings.hpp"
#include "gateway/status/quality_text.hpp"

namespace mbgate::gateway {
namespace {

// A line is asked for too much if it is hardly ever idle and requests wait for so long: half of
// them, or those of the client address with the most.
constexpr unsigned kFullLoad = 95;
constexpr Duration kLongWait = std::chrono::milliseconds(500);
// One client address makes a line too busy if so many percent of what waits are its requests.
constexpr std::size_t kMostOfAll = 75;
// A line that had no silence for too long has had one since.
constexpr Duration kSilentAgain = std::chrono::seconds(10);

constexpr auto kHeardItself = "requests come back as they were sent";

// Whatever came was no answer. What its adapter hears of itself is no bytes of somebody else.
bool was_anything_heard(const BusStatus& bus) {
  const bus::BusCounters& counters = bus.counters;
  return counters.stray_bytes + counters.noise_bytes + counters.bad_crcs > 0 ||
         (bus.echo == bus::NoticedEcho::none && counters.unsolicited_frames > 0);
}

Diagnosis of_dead_bus(const BusStatus& bus, const Together& all) {
  std::string evidence = counted(all.unanswered, "transmission") + " in a row to " +
                         counted(all.silent, "device") + " unanswered";
  if (!was_anything_heard(bus)) {
    evidence += bus.echo == bus::NoticedEcho::none ? ", and nothing else heard"
                                                   : ", and nothing heard but what was sent";
  }
  if (all.had_answers) {
    return {subject_of(bus), "nothing answers any more", std::move(evidence),
            bus.is_serial ? "the plug and the cable of the line; the power of the drives"
                          : "the server and what is behind it"};
  }
  std::string look_at =
      bus.is_serial ? "power; A and B; unit addresses; the drives' setting, here " + mode_text(bus)
                    : "unit identifiers; whether the server is a Modbus TCP server";
  if (bus.counters.echo_mismatches > 0) {
    look_at += "; `echo`: what came back is not what was sent";
  }
  return {subject_of(bus), "nothing answers", std::move(evidence), std::move(look_at)};
}

// A request can only be another client's. A frame of a drive may be the second drive's, too.
Diagnosis of_foreign_frames(const BusStatus& bus) {
  const std::string evidence = "the last one " + seconds_text(*bus.last_foreign) + " ago, " +
                               std::to_string(bus.counters.foreign_frames) + " in all";
  if (is_lately(bus.last_foreign_request)) {
    return {subject_of(bus), "requests are heard that nobody here sent", evidence,
            "another client on this line (a second gateway, PLC or tool)"};
  }
  return {subject_of(bus), "frames are heard that nobody here sent or asked for", evidence,
          "another client on this line (a second gateway, PLC or tool), or two devices at one "
          "address"};
}

bool is_flooded(const StatusReport& report, const BusStatus& bus) {
  constexpr std::size_t kPercent = 100;
  const auto& most = bus.most_waiting;
  return most && most->longest >= kLongWait &&
         most->requests * kPercent >= bus.waiting * kMostOfAll &&
         std::ranges::any_of(report.clients, [&](const ClientStatus& client) {
           return client.address != most->address && client.requests > 0;
         });
}

// Where drives let requests time out, these take the time, and the line could carry more.
void diagnose_load(const StatusReport& report, const BusStatus& bus, const Together& all,
                   std::vector<Diagnosis>& found) {
  if (bus.load < kFullLoad || all.are_waited_for) {
    return;
  }
  const std::string busy = "busy " + std::to_string(bus.load) + " % of the time; ";
  if (is_flooded(report, bus)) {
    found.push_back({"client " + bus.most_waiting->address,
                     "it asks for more than " + subject_of(bus) + " can carry",
                     subject_of(bus) + " is " + busy + std::to_string(bus.most_waiting->requests) +
                         " of the " + counted(bus.waiting, "request") +
                         " that wait are its, the oldest for " +
                         milliseconds_text(bus.most_waiting->longest),
                     "how often it asks, and on how many connections; `pipeline`; `cache`, "
                     "`merge` for what it reads"});
  } else if (all.shortest_wait && *all.shortest_wait >= kLongWait) {
    found.push_back(
        {subject_of(bus), "it is asked for more than it can carry",
         busy + "half of the requests wait " + milliseconds_text(*all.shortest_wait) + " or longer",
         "poll less often; longer reads instead of many; `cache`, `merge`; baud rate"});
  }
}

}  // namespace

void diagnose_bus(const StatusReport& report, const BusStatus& bus, const Together& all,
                  std::vector<Diagnosis>& found) {
  if (!bus.is_open && !bus.is_starting) {
    found.push_back({subject_of(bus), "it is not open: nothing can be sent",
                     bus.line + " could not be opened, or was lost",
                     bus.is_serial
                         ? "the adapter and its plug; `device`; who else has the port open"
                         : "the network, the server and its port"});
  } else if (bus.last_never_silent && *bus.last_never_silent < kSilentAgain) {
    found.push_back({subject_of(bus), "it is never silent: nothing can be sent",
                     "bytes came without the silence that a request needs before it, the last " +
                         seconds_text(*bus.last_never_silent) + " ago",
                     "another client on this line, baud rate, termination or bias"});
  } else if (all.is_dead() && bus.echo != bus::NoticedEcho::denied) {
    found.push_back(of_dead_bus(bus, all));
  }
  if (bus.echo == bus::NoticedEcho::denied) {
    found.push_back({subject_of(bus), "it hears what it sends, and `echo = false` denies it",
                     kHeardItself,
                     "say `echo = true`: else answers are taken for those to another client, and "
                     "the echo of a write for its answer"});
  }
  if (is_lately(bus.last_foreign)) {
    found.push_back(of_foreign_frames(bus));
  }
  if (is_bad(bus.quality)) {
    found.push_back(diagnosis_of_quality(subject_of(bus), bus.quality, true));
  }
  diagnose_load(report, bus, all, found);
  if (bus.echo == bus::NoticedEcho::found) {
    found.push_back({subject_of(bus), "it hears what it sends, and `echo` does not say so",
                     kHeardItself,
                     "say `echo = true`, or let the adapter not receive while it sends; until the "
                     "echo is found again after each opening, the answer to a write may be its "
                     "echo"});
  }
}

}  // namespace mbgate::gateway
