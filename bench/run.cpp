// SPDX-License-Identifier: Apache-2.0
#include "run.hpp"

#include <sys/mman.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <stdexcept>
#include <system_error>
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
  std::vector<Child> handshakes;
};

/// A number that child processes count up.
class SharedCount {
 public:
  SharedCount()
      : place_(::mmap(nullptr, sizeof(std::uint64_t), PROT_READ | PROT_WRITE,
                      MAP_SHARED | MAP_ANONYMOUS, -1, 0)) {
    if (place_ == MAP_FAILED) {
      throw std::system_error(errno, std::generic_category(), "mmap");
    }
  }
  ~SharedCount() { ::munmap(place_, sizeof(std::uint64_t)); }
  SharedCount(const SharedCount&) = delete;
  SharedCount& operator=(const SharedCount&) = delete;

  [[nodiscard]] std::uint64_t& place() const { return *static_cast<std::uint64_t*>(place_); }
  [[nodiscard]] std::uint64_t value() const { return std::atomic_ref(place()).load(); }

 private:
  void* place_;
};

Loads start_loads(const Scenario& scenario, const Subject& subject, const Times& times,
                  const SharedCount& handshakes) {
  Loads loads;
  if (subject.doors().ports.empty()) {
    return loads;
  }
  for (unsigned count = 0; count < scenario.load.handshakes; ++count) {
    loads.handshakes.push_back(Child::run([&](int) {
      run_handshakes(subject.tls_files(), subject.handshake_port(), handshakes.place());
    }));
  }
  loads.clients.emplace(Child::run([&](int output) {
    run_load(scenario.load, scenario.plant, subject.doors(), times, output);
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
  const SharedCount handshakes;
  const Loads loads = start_loads(scenario, subject, times, handshakes);
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
  const std::uint64_t handshakes_before = handshakes.value();
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
  result.handshakes = handshakes.value() - handshakes_before;
  if (std::ranges::any_of(loads.handshakes, [](const Child& one) { return !one.lives(); })) {
    throw std::runtime_error(scenario.name + ": the handshakes could not go on");
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
