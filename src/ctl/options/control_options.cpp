// SPDX-License-Identifier: Apache-2.0
// Subcommands that ask a running mbgated.
#include <arpa/inet.h>

#include <CLI/CLI.hpp>
#include <array>
#include <fmt/core.h>
#include <memory>

#include "ctl/options/subcommands.hpp"
#include "ctl/request/value_text.hpp"
#include "modbus/codes.hpp"

namespace mbgate::ctl {
namespace {

// A status has every device and client in it: it is not asked for as often as a register may be.
constexpr std::chrono::milliseconds kShortestPeriodOfStatus{100};
constexpr unsigned kMost = 1'000'000'000;

struct StatusWords {
  StatusCommand command;
  bool watch = false;
  std::string every = "1s";
};

struct TraceWords {
  TraceCommand command;
  std::string function;
};

bool is_ip_address(const std::string& text) {
  std::array<unsigned char, sizeof(in6_addr)> octets{};
  return ::inet_pton(AF_INET, text.c_str(), octets.data()) == 1 ||
         ::inet_pton(AF_INET6, text.c_str(), octets.data()) == 1;
}

TraceCommand trace_of(const TraceWords& words) {
  TraceCommand trace = words.command;
  if (!trace.filter.client.empty() && !is_ip_address(trace.filter.client)) {
    throw WrongUsage(fmt::format(
        "--client \"{}\" is not an IP address, like 192.168.10.5 or fd00::5", trace.filter.client));
  }
  if (!words.function.empty()) {
    const auto code = parse_address(words.function);  // decimal or hex, as an address
    if (!code || *code == 0 || *code >= modbus::kExceptionBit) {
      throw WrongUsage(fmt::format(
          "--function \"{}\" is not a function code: 1 to 127, like 3 or 0x10", words.function));
    }
    trace.filter.function = static_cast<std::uint8_t>(*code);
  }
  if (trace.pcapng == "-" && trace.json) {
    throw WrongUsage("--json and --pcapng - both want standard output: name a file for one");
  }
  return trace;
}

}  // namespace

void add_status(CLI::App& app, const Choose& choose) {
  auto* status = app.add_subcommand(
      "status", "Show the status of a running mbgated, its lines and its drives: faults first.");
  const auto words = std::make_shared<StatusWords>();
  auto* watch = status->add_flag(
      "--watch", words->watch,
      "show it again and again, on a terminal in place, until q is typed or it is interrupted");
  status->add_option("--every", words->every, "with --watch: at this interval")->needs(watch);
  status->add_option("--times", words->command.times, "with --watch: end after this many times")
      ->needs(watch)
      ->check(CLI::Range(1U, kMost));
  status->add_flag("--json", words->command.json, "for programs: one JSON object a line");
  add_control(*status, words->command.socket, true);
  status->callback([words, choose] {
    if (words->watch) {
      words->command.every = parse_time(words->every, kShortestPeriodOfStatus);
    }
    choose(words->command);
  });
}

void add_reload(CLI::App& app, const Choose& choose) {
  auto* reload = app.add_subcommand(
      "reload",
      "Have a running mbgated read its configuration again, and say what has changed or why it was "
      "refused.");
  const auto words = std::make_shared<ReloadCommand>();
  add_control(*reload, words->socket, false);
  reload->callback([words, choose] { choose(*words); });
}

void add_clear_counters(CLI::App& app, const Choose& choose) {
  auto* clear = app.add_subcommand(
      "clear-counters",
      "Set all counters of a running mbgated to zero: those of lines, drives and requests.");
  const auto words = std::make_shared<ClearCountersCommand>();
  add_control(*clear, words->socket, false);
  clear->callback([words, choose] { choose(*words); });
}

void add_events(CLI::App& app, const Choose& choose) {
  auto* events = app.add_subcommand(
      "events", "Print what a running mbgated writes to the journal, as it is written.");
  const auto words = std::make_shared<EventsCommand>();
  events->add_flag("--json", words->json, "for programs: one JSON object a line");
  add_control(*events, words->socket, true);
  events->callback([words, choose] { choose(*words); });
}

void add_trace(CLI::App& app, const Choose& choose) {
  auto* trace = app.add_subcommand(
      "trace",
      "Print what goes through a running mbgated: each request, what was sent on the line for it, "
      "what was received, and what the client got.");
  const auto words = std::make_shared<TraceWords>();
  TraceCommand& command = words->command;
  TraceFilter& filter = command.filter;
  trace->add_option("--bus", filter.bus, "only what goes over this bus")->type_name("NAME");
  trace->add_option("--device", filter.device, "only what concerns this device")->type_name("NAME");
  trace->add_option("--client", filter.client, "only requests of this client, by its IP address")
      ->type_name("ADDRESS");
  trace->add_option("--function", words->function, "only requests with this function code")
      ->type_name("N");
  trace->add_flag("--failed", filter.only_failed, "only what failed");
  trace->add_flag("--json", command.json, "for programs: one JSON object a line");
  auto* pcapng = trace
                     ->add_option("--pcapng", command.pcapng,
                                  "write a capture for Wireshark too; - is standard output")
                     ->type_name("FILE");
  trace->add_flag("--quiet", command.quiet, "with --pcapng: print nothing")->needs(pcapng);
  trace->add_option("--times", command.times, "end after this many records")
      ->check(CLI::Range(1U, kMost));
  add_control(*trace, command.socket, true);
  trace->callback([words, choose] { choose(trace_of(*words)); });
}

}  // namespace mbgate::ctl
