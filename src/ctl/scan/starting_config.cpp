// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <fmt/core.h>

#include "config/toml/duration_text.hpp"
#include "config/toml/match_entry.hpp"
#include "config/toml/toml_value.hpp"
#include "ctl/scan/scan_report.hpp"

namespace mbgate::ctl {
namespace {

using namespace std::chrono_literals;

constexpr std::array kRoundTimes{100ms,  200ms,  300ms,  500ms,   1000ms,
                                 2000ms, 3000ms, 5000ms, 10'000ms};
constexpr unsigned kMargin = 3;

std::string quoted(const std::string& text) { return config::in_quotes(text); }

std::string head(const std::string& where, const std::string& bus) {
  return fmt::format(
      "# What mbgatectl scan found at {}. Look through every line before it\n"
      "# runs: a scan only reads, and what reading cannot tell is marked CHOOSE.\n"
      "\n"
      "[[listen]]\n"
      "name = \"plant\"\n"
      "address = \"127.0.0.1\"          # CHOOSE: the address that the clients reach, and who may: "
      "`allow`\n"
      "port = 502\n"
      "\n"
      "[[bus]]\n"
      "name = {}\n",
      where, quoted(bus));
}

std::string line_to_choose() {
  return "device = \"/dev/ttyUSB0\"        # CHOOSE: better a name in /dev/serial/by-id\n"
         "baud = 19200                   # CHOOSE these three as the line is set now\n"
         "parity = \"even\"\n"
         "stop_bits = 1\n";
}

std::string line_as_found(const FoundLine& line) {
  std::string text = "device = " + quoted(line.device);
  if (line.lasting_name) {
    text += fmt::format("  # CHOOSE: better {}, which stays the same", quoted(*line.lasting_name));
  }
  const auto& [baud, format] = line.mode;
  return fmt::format(
      "{}\nbaud = {}  # the units answered with these three\nparity = {}\nstop_bits = {}\n", text,
      static_cast<std::uint32_t>(baud), quoted(std::string(parity_word(format.parity))),
      format.stop_bits);
}

std::string source_of(const FoundUnit& unit) {
  const auto& found = unit.identification;
  std::string text;
  for (const auto& [name, value] : found.texts) {
    text += fmt::format("# {}: {}\n", name, quoted(value));
  }
  return text;
}

std::string profile_lines(const Identification& found) {
  if (found.likely.empty()) {
    return "# No profile fits: generic limits, no 32-bit values. A profile can be written for it.\n"
           "profile = \"generic\"\n";
  }
  if (found.likely.size() == 1) {
    const auto& file = *found.likely.front();
    return fmt::format("profile = {}  # {}; {} of {} answers fit\n", quoted(file.profile.name),
                       file.description, found.fitting, found.judged);
  }
  std::string text = "# CHOOSE one: reading cannot tell them apart, and their values differ.\n";
  for (const auto* file : found.likely) {
    text += fmt::format("# profile = {}  # {}\n", quoted(file->profile.name), file->description);
  }
  return text;
}

std::string order_lines(const Identification& found) {
  if (word_order_unknown(found)) {
    return "# CHOOSE as the drive is set: it does not say.\n"
           "# word_order = \"big\"  # or \"little\"\n";
  }
  if (!found.word_order) {
    return {};
  }
  const auto line =
      fmt::format("word_order = {}", quoted(std::string(config::order_word(*found.word_order))));
  return found.likely.size() == 1 ? line + "\n" : fmt::format("# {}  # as read\n", line);
}

std::string device(const FoundUnit& unit, const std::string& bus) {
  const auto& found = unit.identification;
  const auto slowest = std::chrono::ceil<std::chrono::milliseconds>(unit.slowest);
  return fmt::format(
      "{}[[device]]\n"
      "name = \"unit-{}\"\n"
      "bus = {}\n"
      "address = {}\n"
      "{}{}response_timeout = {}  # it took up to {}, seen from here\n",
      source_of(unit), unit.unit, quoted(bus), unit.unit, profile_lines(found), order_lines(found),
      quoted(config::to_text(sensible_timeout(unit.slowest))), config::to_text(slowest));
}

std::string route(const FoundUnit& unit) {
  const auto& found = unit.identification;
  const auto name = std::to_string(unit.unit);
  const bool chosen = found.likely.size() <= 1 && !word_order_unknown(found);
  return fmt::format(
      "[[route]]\nunit = {}\ndevice = \"unit-{}\"\n{}", name, name,
      chosen ? "word_order = \"big\"\n"
             : "# word_order = \"big\"  # once the choice above is made: what the clients see\n");
}

std::string units(const std::string& bus, const std::vector<FoundUnit>& found) {
  std::string text;
  for (const auto& unit : found) {
    text += fmt::format("\n{}\n{}", device(unit, bus), route(unit));
  }
  return text;
}

}  // namespace

std::string starting_config(const Target& target, const std::string& bus,
                            const std::vector<FoundUnit>& found) {
  return head(fmt::format("{}, port {}", target.host, target.port), bus) + line_to_choose() +
         units(bus, found);
}

std::string starting_config(const FoundLine& line, const std::string& bus,
                            const std::vector<FoundUnit>& found) {
  return head(line.device, bus) + line_as_found(line) + units(bus, found);
}

std::chrono::milliseconds sensible_timeout(std::chrono::nanoseconds slowest) {
  for (const auto time : kRoundTimes) {
    if (time >= kMargin * slowest) {
      return time;
    }
  }
  return std::chrono::ceil<std::chrono::seconds>(kMargin * slowest);
}

}  // namespace mbgate::ctl
