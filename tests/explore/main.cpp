// SPDX-License-Identifier: Apache-2.0
// gateway_explore: all that may happen in small worlds around the product's own gateway.
#include <charconv>
#include <chrono>
#include <cstdio>
#include <fmt/format.h>
#include <string>
#include <string_view>

#include "explore/explorer.hpp"

namespace {

using namespace mbgate::explore;

constexpr double kMegabyte = 1024.0 * 1024.0;

struct Options {
  Bounds bounds{2, 1, 1};
  std::string world = "usual";
  Merging merging = Merging::on;
  Path path;
  bool is_replay = false;
};

bool read_number(std::string_view text, std::uint64_t& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc{} && end == text.data() + text.size();
}

bool read_path(std::string_view text, Path& path) {
  while (!text.empty()) {
    const std::size_t comma = std::min(text.find(','), text.size());
    std::uint64_t place = 0;
    if (!read_number(text.substr(0, comma), place)) {
      return false;
    }
    path.push_back(static_cast<std::uint16_t>(place));
    text.remove_prefix(std::min(comma + 1, text.size()));
  }
  return true;
}

bool read_value(std::string_view name, std::string_view text, Options& options) {
  std::uint64_t number = 0;
  if (name == "--world") {
    options.world = text;
    return text == "all" || find_plant(text) != nullptr;
  }
  if (name == "--replay") {
    options.is_replay = true;
    return read_path(text, options.path);
  }
  if (!read_number(text, number)) {
    return false;
  }
  unsigned* bound = name == "--requests"   ? &options.bounds.requests
                    : name == "--faults"   ? &options.bounds.faults
                    : name == "--delays"   ? &options.bounds.delays
                    : name == "--instants" ? &options.bounds.instants
                                           : nullptr;
  if (bound != nullptr) {
    *bound = static_cast<unsigned>(number);
  }
  return bound != nullptr && number <= kSlots;
}

bool parse(int count, char** arguments, Options& options) {
  for (int at = 1; at < count; ++at) {
    const std::string_view name = arguments[at];
    if (name == "--forms") {
      options.bounds.forms = true;
    } else if (name == "--drives") {
      options.bounds.drives = true;
    } else if (name == "--compare") {
      options.merging = Merging::compared;
    } else if (at + 1 == count || !read_value(name, arguments[++at], options)) {
      return false;
    }
  }
  return 2 * (options.bounds.faults + 1) * (options.bounds.delays + 1) <= kMostSlacks;
}

/// True: nothing is violated.
bool explore(const Plant& plant, const Options& options) {
  const auto& [requests, faults, delays, forms, drives, instants] = options.bounds;
  const auto begun = std::chrono::steady_clock::now();
  const Findings found = Explorer(plant, options.bounds, options.merging).run();
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begun;
  fmt::print(
      "{}: {} requests, {} faults{}{}, {} delays, {} instants an edge: complete, {} states, {} "
      "transitions, {} merged, {} ends, {} deep, {} learning, {} violations, {:.1f} s, {:.0f} MB\n",
      plant.name, requests, faults, forms ? " of all forms" : "", drives ? " of drives too" : "",
      delays, instants, found.states, found.transitions, found.merged, found.ends, found.deepest,
      found.learning, found.violated, took.count(), static_cast<double>(found.memory) / kMegabyte);
  for (const Violation& violation : found.violations) {
    fmt::print("\nVIOLATION {}\n", violation.what);
    static_cast<void>(replay(plant, options.bounds, violation.path));
    fmt::print(
        "replay: gateway_explore --world {} --requests {} --faults {} --delays {}{}{} --instants "
        "{} "
        "--replay {}\n",
        plant.name, requests, faults, delays, forms ? " --forms" : "", drives ? " --drives" : "",
        instants, fmt::join(violation.path, ","));
  }
  std::fflush(stdout);
  return found.violations.empty();
}

void print_usage() {
  std::fputs(
      "usage: gateway_explore [--world NAME|all] [--requests N] [--faults N] [--delays N]\n"
      "                       [--instants 1|2|3] [--forms] [--drives]\n"
      "                       [--compare] [--replay PATH]\n"
      "(faults + 1) * (delays + 1) is at most 16; tests/README.md says what each option does.\n"
      "worlds:\n",
      stderr);
  for (const Plant& plant : plants()) {
    std::fprintf(stderr, "  %-14s %s\n", std::string(plant.name).c_str(),
                 std::string(plant.what).c_str());
  }
}

}  // namespace

int main(int count, char** arguments) {
  Options options;
  if (!parse(count, arguments, options)) {
    print_usage();
    return 2;
  }
  if (options.is_replay) {
    const Plant& plant = *find_plant(options.world);
    const std::string violation = replay(plant, options.bounds, options.path);
    std::printf("%s\n", violation.empty() ? "no violation" : ("VIOLATION " + violation).c_str());
    return violation.empty() ? 0 : 1;
  }
  bool holds = true;
  for (const Plant& plant : plants()) {
    if (options.world == "all" || options.world == plant.name) {
      holds = explore(plant, options) && holds;
    }
  }
  return holds ? 0 : 1;
}
