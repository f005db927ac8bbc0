// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <fmt/format.h>

#include "config/toml/match_entry.hpp"
#include "config/toml/toml_value.hpp"
#include "ctl/scan/scan_report.hpp"

namespace mbgate::ctl {
namespace {

using config::in_quotes;
using namespace std::chrono_literals;

constexpr std::array kRoundTimes{100ms,  200ms,  300ms,  500ms,   1000ms,
                                 2000ms, 3000ms, 5000ms, 10'000ms};
constexpr unsigned kMargin = 3;

/// With a good margin over the slowest answer that was seen: at least three times as long, at least
/// 100 ms, rounded.
std::chrono::milliseconds sensible_timeout(std::chrono::nanoseconds slowest) {
  for (const auto time : kRoundTimes) {
    if (time >= kMargin * slowest) {
      return time;
    }
  }
  return std::chrono::ceil<std::chrono::seconds>(kMargin * slowest);
}

std::string head(const std::string& where, const std::string& bus) {
  return fmt::format(R"(# What mbgatectl scan found at {}. Check every line before you use
# it: a scan only reads, and what it cannot find out is marked CHOOSE.

[[listen]]
name = "plant"
address = "127.0.0.1"          # CHOOSE: the address that the clients use, and `allow`, the permitted clients
port = 502

[[bus]]
name = {}
)",
                     where, in_quotes(bus));
}

constexpr const char* kLineToChoose =
    R"(device = "/dev/ttyUSB0"        # CHOOSE: better a name in /dev/serial/by-id
baud = 19200                   # CHOOSE these three as the line is set now
parity = "even"
stop_bits = 1
)";

std::string line_as_found(const FoundLine& line) {
  const auto better = line.lasting_name ? fmt::format("  # CHOOSE: better {}, which stays the same",
                                                      in_quotes(*line.lasting_name))
                                        : "";
  const auto& [baud, format] = line.mode;
  return fmt::format(R"(device = {}{}
baud = {}  # the units answered with these three
parity = {}
stop_bits = {}
)",
                     in_quotes(line.device), better, fmt::underlying(baud),
                     in_quotes(config::word_for(config::kParities, format.parity)),
                     format.stop_bits);
}

std::string source_of(const FoundUnit& unit) {
  const auto& found = unit.identification;
  std::string text;
  for (const auto& [name, value] : found.texts) {
    text += fmt::format("# {}: {}\n", name, in_quotes(value));
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
    return fmt::format("profile = {}  # {}; {} of {} answers fit\n", in_quotes(file.profile.name),
                       file.description, found.fitting, found.judged);
  }
  std::string text = "# CHOOSE one: reading cannot tell them apart, and their values differ.\n";
  for (const auto* file : found.likely) {
    text += fmt::format("# profile = {}  # {}\n", in_quotes(file->profile.name), file->description);
  }
  return text;
}

std::string order_lines(const Identification& found) {
  if (word_order_unknown(found)) {
    return "# CHOOSE the setting of the drive, which cannot be read.\n"
           "# word_order = \"big\"  # or \"little\"\n";
  }
  if (!found.word_order) {
    return {};
  }
  const auto line =
      fmt::format("word_order = {}", in_quotes(config::order_word(*found.word_order)));
  return found.likely.size() == 1 ? line + "\n" : fmt::format("# {}  # as read\n", line);
}

/// None where the profile has a timeout that the answers kept.
std::string timeout_line(const FoundUnit& unit) {
  const auto& likely = unit.identification.likely;
  const auto is_enough = [&](const auto* file) {
    return file->profile.response_timeout >= unit.slowest;
  };
  if (!likely.empty() && std::ranges::all_of(likely, is_enough)) {
    return {};
  }
  const auto slowest = std::chrono::ceil<std::chrono::milliseconds>(unit.slowest);
  return fmt::format("response_timeout = {}  # it took up to {}, seen from here\n",
                     in_quotes(config::to_text(sensible_timeout(unit.slowest))),
                     config::to_text(slowest));
}

std::string device(const FoundUnit& unit, const std::string& bus) {
  const auto& found = unit.identification;
  return fmt::format(R"({}[[device]]
name = "unit-{}"
bus = {}
address = {}
{}{})",
                     source_of(unit), unit.unit, in_quotes(bus), unit.unit, profile_lines(found),
                     order_lines(found));
}

std::string route(const FoundUnit& unit) {
  const auto& found = unit.identification;
  const auto text = fmt::format("[[route]]\nunit = {0}\ndevice = \"unit-{0}\"\n", unit.unit);
  if (found.likely.size() > 1 || word_order_unknown(found)) {
    return text + "# word_order = \"big\"  # once the choice above is made: what the clients see\n";
  }
  return text + (found.word_order ? "word_order = \"big\"\n" : "");
}

/// Through a gateway, its queue would be in the times.
std::string units(const std::string& bus, const std::vector<FoundUnit>& found, bool is_timed) {
  std::string text;
  for (const auto& unit : found) {
    text += fmt::format("\n{}{}\n{}", device(unit, bus), is_timed ? timeout_line(unit) : "",
                        route(unit));
  }
  return text;
}

}  // namespace

std::string starting_config(const Target& target, const std::string& bus,
                            const std::vector<FoundUnit>& found) {
  return head(fmt::format("{}, port {}", target.host, target.port), bus) + kLineToChoose +
         units(bus, found, false);
}

std::string starting_config(const FoundLine& line, const std::string& bus,
                            const std::vector<FoundUnit>& found) {
  return head(line.device, bus) + line_as_found(line) + units(bus, found, true);
}

}  // namespace mbgate::ctl
