// SPDX-License-Identifier: Apache-2.0
#include "run.hpp"

#include <stdexcept>
#include <thread>

namespace mbgate::bench {
namespace {

/// Beyond the times asked for: connecting, and coming to an end.
constexpr std::chrono::seconds kMargin{30};

std::chrono::milliseconds limit(Nanoseconds time) {
  return std::chrono::ceil<std::chrono::milliseconds>(time) + kMargin;
}

/// The clients and the flood, once they have their ports.
struct Loads {
  std::optional<Child> clients;
  std::optional<Child> flood;
};

Loads start_loads(const Scenario& scenario, const Subject& subject, const Times& times) {
  Loads loads;
  if (subject.ports().empty()) {
    return loads;
  }
  loads.clients.emplace(Child::run([&](int output) {
    run_load(scenario.load, scenario.plant, subject.ports(), times, output);
  }));
  if (scenario.load.flood > 0) {
    loads.flood.emplace(
        Child::run([&](int) { run_flood(scenario.load.flood, subject.flood_port()); }));
  }
  return loads;
}

}  // namespace

RunResult run_once(const Scenario& scenario, const Means& means, const Times& times) {
  BusSimulator simulator(scenario.plant, means.folder);
  const Subject subject(scenario, means, simulator.paths());
  // All that forks is there: now threads may be.
  const Loads loads = start_loads(scenario, subject, times);
  simulator.start();

  RunResult result;
  if (loads.clients) {
    char began = 0;
    if (!loads.clients->receive(&began, sizeof began, limit(times.warm_up))) {
      throw std::runtime_error(scenario.name + ": the clients did not begin");
    }
  } else {
    std::this_thread::sleep_for(times.warm_up);
  }
  const auto allocations = subject.allocations();
  const Usage before = subject.process().usage();
  const Moment start = Clock::now();
  simulator.begin();
  if (!loads.clients) {
    std::this_thread::sleep_for(times.measured);
  } else if (!loads.clients->receive(&result.clients, sizeof result.clients,
                                     limit(times.measured))) {
    throw std::runtime_error(scenario.name + ": the clients did not come to an end");
  }
  result.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  result.used = subject.process().usage();
  result.used.processor -= before.processor;
  result.used.context_switches -= before.context_switches;
  if (allocations) {
    result.allocations = subject.allocations().value_or(*allocations) - *allocations;
  }
  if (!subject.process().lives()) {
    throw std::runtime_error(scenario.name + " ended while it was measured");
  }
  if (loads.flood && !loads.flood->lives()) {
    throw std::runtime_error(scenario.name + ": the flood could not go on");
  }
  result.buses = simulator.end();
  if (!loads.clients) {
    for (const WireFigures& bus : result.buses) {
      result.clients.answers += bus.transactions;
    }
    result.clients.seconds = result.seconds;
  }
  return result;
}

}  // namespace mbgate::bench
