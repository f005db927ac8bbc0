// SPDX-License-Identifier: Apache-2.0
// gateway_soak: the product's own gateway under every fault that the oracle knows, seed after seed.
#include <charconv>
#include <chrono>
#include <cstdio>
#include <exception>
#include <new>
#include <string_view>

#include "soak/world.hpp"

namespace {

struct Options {
  std::uint64_t seed = 1;
  std::uint64_t seeds = 1;
  std::uint64_t transactions = 2000;
  bool verbose = false;
  bool trace = false;
  bool breaks_promise = false;
};

bool parse(int count, char** arguments, Options& options) {
  for (int at = 1; at < count; ++at) {
    const std::string_view name = arguments[at];
    if (name == "--verbose") {
      options.verbose = true;
      continue;
    }
    if (name == "--trace") {
      options.trace = true;
      continue;
    }
    if (name == "--break-promise") {
      options.breaks_promise = true;
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

// What is thrown ends a seed, not the run.
mbgate::soak::Report run(std::uint64_t seed, const Options& options) {
  mbgate::soak::Report report;
  try {
    mbgate::soak::World world(seed, options.trace);
    if (options.breaks_promise) {
      world.break_promise();
    }
    report = world.run(options.transactions);
  } catch (const std::bad_alloc&) {
    report.violation("no_progress", "the gateway takes memory without end");
  } catch (const std::exception& error) {
    report.violation("thrown", error.what());
  }
  return report;
}

}  // namespace

int main(int count, char** arguments) {
  Options options;
  if (!parse(count, arguments, options)) {
    std::fputs(
        "usage: gateway_soak [--seed N] [--seeds K] [--transactions M] [--verbose] [--trace]\n"
        "                    [--break-promise]\n"
        "Runs seeds N to N+K-1, each until M transactions were seen on its wires. With\n"
        "--break-promise the driver judges deadlines before it reads: there must be violations.\n",
        stderr);
    return 2;
  }
  mbgate::soak::Report total;
  std::uint64_t failed = 0;
  const auto begun = std::chrono::steady_clock::now();
  for (std::uint64_t seed = options.seed; seed < options.seed + options.seeds; ++seed) {
    const mbgate::soak::Report report = run(seed, options);
    total.add(report);
    if (options.verbose) {
      std::printf("seed %llu: %s", static_cast<unsigned long long>(seed), report.summary().c_str());
    }
    if (report.violation_count() == 0) {
      continue;
    }
    ++failed;
    for (const std::string& text : report.texts) {
      std::printf("seed %llu: %s\n", static_cast<unsigned long long>(seed), text.c_str());
    }
    std::printf("replay: gateway_soak --seed %llu --transactions %llu\n",
                static_cast<unsigned long long>(seed),
                static_cast<unsigned long long>(options.transactions));
    std::fflush(stdout);
  }
  const std::chrono::duration<double> real = std::chrono::steady_clock::now() - begun;
  std::printf("%llu seeds, %llu with violations: %s  %.1f s, %.0f transactions a second\n",
              static_cast<unsigned long long>(options.seeds),
              static_cast<unsigned long long>(failed), total.summary().c_str(), real.count(),
              static_cast<double>(total.transmissions) / real.count());
  return failed == 0 ? 0 : 1;
}
