// SPDX-License-Identifier: Apache-2.0
// soak: the product's own gateway in a world as bad as a plant, seed after seed, before its judge.
#include <charconv>
#include <chrono>
#include <cstdio>
#include <string_view>

#include "judge/drill.hpp"
#include "judge/run.hpp"

namespace {

struct Options {
  std::uint64_t seed = 1;
  std::uint64_t seeds = 1;
  std::uint64_t transactions = 2000;
  bool verbose = false;
  bool trace = false;
  bool first = false;
};

bool parse(int count, char** arguments, Options& options) {
  for (int at = 1; at < count; ++at) {
    const std::string_view name = arguments[at];
    bool* flag = name == "--verbose" ? &options.verbose
                 : name == "--trace" ? &options.trace
                 : name == "--first" ? &options.first
                                     : nullptr;
    if (flag != nullptr) {
      *flag = true;
      continue;
    }
    std::uint64_t* number = name == "--seed"           ? &options.seed
                            : name == "--seeds"        ? &options.seeds
                            : name == "--transactions" ? &options.transactions
                                                       : nullptr;
    if (number == nullptr || at + 1 == count) {
      return false;
    }
    const std::string_view text = arguments[++at];
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), *number);
    if (error != std::errc{} || end != text.data() + text.size()) {
      return false;
    }
  }
  return true;
}

}  // namespace

int main(int count, char** arguments) {
  Options options;
  if (count == 2 && std::string_view(arguments[1]) == "--bounds") {
    return mbgate::judge::run_bounds() ? 0 : 1;
  }
  if (!parse(count, arguments, options)) {
    std::fputs(
        "usage: soak [--seed N] [--seeds K] [--transactions M] [--verbose] [--trace] [--first]\n"
        "       soak --bounds\n"
        "Runs seeds N to N+K-1, each until M transmissions were seen on its lines. --first ends "
        "at\n"
        "the first seed with a violation. --bounds runs plants that are made for figures of time\n"
        "and shares; it fails if one is out that is kept today.\n",
        stderr);
    return 2;
  }
  mbgate::world::Report total;
  std::uint64_t failed = 0;
  std::uint64_t seeds = 0;
  const auto begun = std::chrono::steady_clock::now();
  for (; seeds < options.seeds && !(options.first && failed > 0); ++seeds) {
    const std::uint64_t seed = options.seed + seeds;
    mbgate::world::Report report =
        mbgate::judge::run(mbgate::world::draw_plan(seed),
                           {.transactions = options.transactions, .trace = options.trace});
    report.add(mbgate::judge::drill(seed, options.trace));
    total.add(report);
    const auto number = static_cast<unsigned long long>(seed);
    if (options.verbose) {
      std::printf("seed %llu: %s", number, report.summary().c_str());
    }
    if (report.violations.empty()) {
      continue;
    }
    ++failed;
    for (const std::string& text : report.texts) {
      std::printf("seed %llu: %s\n", number, text.c_str());
    }
    std::printf("replay: soak --seed %llu --transactions %llu\n", number,
                static_cast<unsigned long long>(options.transactions));
    std::fflush(stdout);
  }
  const std::chrono::duration<double> real = std::chrono::steady_clock::now() - begun;
  std::printf("%llu seeds, %llu with violations: %s  %.1f s, %.0f transactions a second\n",
              static_cast<unsigned long long>(seeds), static_cast<unsigned long long>(failed),
              total.summary().c_str(), real.count(),
              static_cast<double>(total.transactions) / real.count());
  return failed == 0 ? 0 : 1;
}
