// SPDX-License-Identifier: Apache-2.0
// What is wrong with a bus.
#include <fmt/core.h>
#include <utility>

#include "base/text.hpp"
#include "report/findings/findings.hpp"

namespace mbgate::report {
namespace {

using namespace gateway;

// A line is asked for too much if it is hardly ever idle, and half of the requests wait for long.
constexpr unsigned kFullLoad = 95;
constexpr unsigned kLeastWaits = 4;
// One client address makes a line too busy if so many percent of what waits are its requests, and
// so many.
constexpr std::size_t kMostOfAll = 75;
constexpr std::size_t kBacklog = 8;
// A line that had no silence for too long has had one since.
constexpr Duration kSilentAgain = std::chrono::seconds(10);

constexpr auto kHeardItself = "requests come back as they were sent";

// Counters begin anew when they are cleared, both of them.
bool does_echo_differ(const bus::BusCounters& counters) {
  return counters.echo_mismatches > 0 && counters.echo_mismatches * 2 >= counters.transmissions;
}

std::string causes_of_no_answer(const BusStatus& bus) {
  if (is_behind_a_server(bus)) {
    return "power of the drives; A and B at the serial server; rate and parity, which are set "
           "there; whether it passes raw bytes, or speaks Modbus TCP (`mode`); unit addresses";
  }
  if (!bus.is_serial) {
    return "unit identifiers; whether the server is a Modbus TCP server";
  }
  return fmt::format(
      "power; the cable and its plug; A and B; whether `device` is the port of this line; unit "
      "addresses; the drives' setting, here {}; RTU or ASCII (`mode`); how the direction is "
      "switched (`rs485`)",
      mode_text(bus));
}

Diagnosis of_dead_bus(const BusStatus& bus, const Together& all) {
  std::string evidence =
      fmt::format("{} in a row to {} unanswered", counted(all.unanswered, "transmission"),
                  counted(all.silent, "device"));
  if (all.unreached == all.silent) {
    return {Rank::nothing_works, subject_of(bus), "the server answers, but reaches no device",
            std::move(evidence),
            "the devices behind the server: power, wires, settings; unit identifiers"};
  }
  if (bus.silence >= all.silent_for) {
    evidence += ", and nothing else heard";
  }
  if (all.had_answers) {
    return {Rank::nothing_works, subject_of(bus), "nothing answers any more", std::move(evidence),
            bus.is_serial ? "the plug and the cable of the line; the power of the drives"
                          : "the server and the devices behind it"};
  }
  std::string look_at = causes_of_no_answer(bus);
  if (does_echo_differ(bus.counters)) {
    look_at += "; `echo`: the received bytes differ from the sent ones";
  }
  return {Rank::nothing_works, subject_of(bus), "nothing answers", std::move(evidence),
          std::move(look_at)};
}

// A request can only be another client's. A frame of a drive may be the second drive's, too.
Diagnosis of_foreign_frames(const BusStatus& bus) {
  std::string evidence = fmt::format("the last one {} ago", passed_text(*bus.last_foreign));
  if (bus.counters.foreign_frames > 0) {  // else they were cleared
    evidence += fmt::format(", {} counted", bus.counters.foreign_frames);
  }
  if (is_lately(bus.last_foreign_request)) {
    return {Rank::warning, subject_of(bus), "requests of another client are heard", evidence,
            "another client on this line (a second gateway, PLC or tool)"};
  }
  return {Rank::warning, subject_of(bus),
          "frames are heard that the gateway neither sent nor asked for", evidence,
          "another client on this line (a second gateway, PLC or tool), or two devices at one "
          "address"};
}

bool is_flooded(const BusStatus& bus) {
  constexpr std::size_t kPercent = 100;
  const auto& most = bus.most_waiting;
  return most && most->requests >= kBacklog && most->longest >= bus::kLongWait &&
         most->requests * kPercent >= most->of * kMostOfAll && most->others_ask;
}

// Where drives let requests time out, these take the time, and the line could carry more. What
// waits at this instant says little: only if requests have waited before, too.
void diagnose_load(const BusStatus& bus, const Together& all, std::vector<Diagnosis>& found) {
  const auto& [requests, are_long] = bus.waits;
  if (bus.load < kFullLoad || all.are_waited_for || are_long < kLeastWaits) {
    return;
  }
  const std::string busy = fmt::format("busy {} % of the time; ", bus.load);
  if (is_flooded(bus)) {
    found.push_back({Rank::warning, "client " + bus.most_waiting->address,
                     fmt::format("it asks for more than {} can carry", subject_of(bus)),
                     fmt::format("{} is {}{} of the {} that wait are from it, the oldest for {}",
                                 subject_of(bus), busy, bus.most_waiting->requests,
                                 counted(bus.most_waiting->of, "request"),
                                 milliseconds_text(bus.most_waiting->longest)),
                     "how often it asks, and on how many connections; `pipeline`; `cache` "
                     "for what it reads"});
  } else if (are_long * 2 >= requests) {
    found.push_back({Rank::warning, subject_of(bus), "it is asked for more than it can carry",
                     fmt::format("{}{} of the last {} waited {} or longer", busy, are_long,
                                 counted(requests, "request"), milliseconds_text(bus::kLongWait)),
                     "poll less often; longer reads instead of many; `cache`; baud rate"});
  }
}

}  // namespace

void diagnose_bus(const BusStatus& bus, const Together& all, std::vector<Diagnosis>& found) {
  if (!bus.is_open && !bus.is_starting && !bus.is_reopening) {
    found.push_back({Rank::nothing_works, subject_of(bus), "it is not open: nothing can be sent",
                     bus.line + " could not be opened, or was lost",
                     bus.is_serial
                         ? "the adapter and its plug; `device`; who else has the port open"
                         : "the network, the server and its port"});
  } else if (bus.last_never_silent && *bus.last_never_silent < kSilentAgain) {
    found.push_back(
        {Rank::nothing_works, subject_of(bus), "it is never silent: nothing can be sent",
         fmt::format(
             "bytes came without the silence that a request needs before it, the last {} ago",
             passed_text(*bus.last_never_silent)),
         "another client on this line, baud rate, termination or bias"});
  } else if (all.is_dead() && !hides_answers(bus.echo)) {
    found.push_back(of_dead_bus(bus, all));
  }
  if (bus.echo == bus::NoticedEcho::denied) {
    found.push_back({all.is_dead() ? Rank::nothing_works : Rank::bad_answers, subject_of(bus),
                     "the adapter receives what it sends, but `echo = false` is set", kHeardItself,
                     "set `echo = true`: otherwise answers are taken for those to another client, "
                     "and the echo of a write for its answer"});
  }
  if (is_lately(bus.last_foreign)) {
    found.push_back(of_foreign_frames(bus));
  }
  if (is_bad(bus.quality)) {
    found.push_back(quality_finding(bus.quality, true));
    found.back().subject = subject_of(bus);
  }
  if (bus.echo == bus::NoticedEcho::unproven) {
    found.push_back({Rank::bad_answers, subject_of(bus),
                     "it is not known whether the adapter receives what it sends",
                     "a write came back unchanged, which acknowledges nothing: such writes get 0B",
                     "set `echo = false`, or `echo = true` if it does; or read from the drive"});
  }
  diagnose_load(bus, all, found);
  if (bus.echo == bus::NoticedEcho::found) {
    found.push_back(
        {Rank::warning, subject_of(bus),
         "the adapter receives what it sends, and `echo` does not say so", kHeardItself,
         "set `echo = true`, or switch the receiver off while the adapter sends; after each "
         "opening, until the echo is found again, the answer to a write may be its echo"});
  }
}

}  // namespace mbgate::report
