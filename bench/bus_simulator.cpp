// SPDX-License-Identifier: Apache-2.0
#include "bus_simulator.hpp"

#include <poll.h>

#include <algorithm>
#include <span>
#include <stdexcept>
#include <utility>

namespace mbgate::bench {
namespace {

/// Before an instant of its own the simulator does not sleep but spin, since a timer rings late;
/// nor does it sleep where a request may come any moment. With more buses it would be nearly
/// always.
constexpr std::chrono::microseconds kSpin{200};
constexpr std::size_t kMostSpinningBuses = 4;
/// The other side gets what has arrived in such portions, as from a UART, and the last byte alone
/// when it is complete.
constexpr std::chrono::milliseconds kPortion{1};
/// No thread waits longer than so for its end.
constexpr std::chrono::milliseconds kLongestWait{50};

}  // namespace

double WireFigures::rate(double seconds) const {
  const double between = std::chrono::duration<double>(last - first).count();
  const auto count = static_cast<double>(transactions);
  return between > 0 ? std::min((count - 1) / between, (count + 1) / seconds) : 0;
}

BusSimulator::BusSimulator(const Plant& plant, const std::filesystem::path& folder)
    : plant_(plant) {
  for (unsigned number = 0; number < plant.buses; ++number) {
    auto pty = sim::Pty::open(folder / ("line-" + std::to_string(number)));
    if (!pty) {
      throw std::runtime_error(pty.error());
    }
    buses_.push_back(Bus{*std::move(pty), number});
    buses_.back().figures.dead_time.reserve(1'000'000 / plant.buses);
    buses_.back().figures.lateness.reserve(1'000'000 / plant.buses);
  }
}

BusSimulator::~BusSimulator() { end(); }

std::vector<std::string> BusSimulator::paths() const {
  std::vector<std::string> paths;
  paths.reserve(buses_.size());
  for (const Bus& bus : buses_) {
    paths.push_back(bus.pty.path());
  }
  return paths;
}

void BusSimulator::start() {
  thread_ = std::thread([this] { run(); });
}

std::vector<WireFigures> BusSimulator::end() {
  ending_ = true;
  if (thread_.joinable()) {
    thread_.join();
  }
  std::vector<WireFigures> figures;
  figures.reserve(buses_.size());
  for (Bus& bus : buses_) {
    figures.push_back(std::move(bus.figures));
  }
  return figures;
}

void BusSimulator::run() {
  want_exact_timers();
  while (!ending_) {
    Moment next = Clock::now() + kLongestWait;
    for (Bus& bus : buses_) {
      next = std::min(next, advance(bus));
    }
    wait(next);
    for (Bus& bus : buses_) {
      const auto bytes = bus.pty.read();
      if (!bytes.empty()) {
        take(bus, bytes, Clock::now());
      }
    }
  }
}

void BusSimulator::wait(Moment next) {
  const Moment now = Clock::now();
  const bool may_spin = plant_.paced() && buses_.size() <= kMostSpinningBuses;
  const bool expects = may_spin && std::ranges::any_of(buses_, [&](const Bus& bus) {
                         return bus.answered && bus.received.empty() && bus.response.empty() &&
                                now >= bus.free_at - kSpin && now < bus.free_at + kSpin;
                       });
  const Moment wake = may_spin ? next - kSpin : next;
  if (expects || now >= wake) {
    return;
  }
  std::vector<pollfd> descriptors;
  descriptors.reserve(buses_.size());
  for (const Bus& bus : buses_) {
    descriptors.push_back({bus.pty.descriptor(), POLLIN, 0});
  }
  const timespec timeout = to_timespec(wake - now);
  ::ppoll(descriptors.data(), descriptors.size(), &timeout, nullptr);
}

Moment BusSimulator::advance(Bus& bus) {
  if (bus.response.empty()) {
    const bool waits_for_free = bus.answered && Clock::now() < bus.free_at - kSpin;
    return waits_for_free ? bus.free_at : Moment::max();
  }
  // Not paced, the whole response is due at once. Else: portions, and the end at its very instant.
  const Moment now = Clock::now();
  const std::size_t size = bus.response.size();
  const Moment complete = bus.response_at + plant_.characters(size);
  std::size_t arrived = size;
  Moment next = complete;
  if (now < complete) {
    const auto portions = std::max<std::int64_t>((now - bus.response_at) / kPortion, 0);
    arrived =
        std::min(size - 1, static_cast<std::size_t>(kPortion * portions / plant_.characters(1)));
    next = std::min(complete, bus.response_at + kPortion * (portions + 1));
  }
  if (arrived > bus.sent) {
    if (arrived == size && measuring_) {
      bus.figures.lateness.add(now - complete);
      bus.figures.last = now;
      if (bus.figures.transactions++ == 0) {
        bus.figures.first = now;
      }
    }
    bus.pty.write(std::span(bus.response).subspan(bus.sent, arrived - bus.sent));
    bus.sent = arrived;
  }
  if (bus.sent < size) {
    return next;
  }
  bus.response.clear();
  bus.free_at = now + plant_.t3_5();
  bus.answered = true;
  return bus.free_at;
}

void BusSimulator::take(Bus& bus, const std::vector<std::uint8_t>& bytes, Moment at) {
  if (bus.received.empty()) {
    bus.began = at;
    const bool too_early = plant_.paced() && (at < bus.free_at || !bus.response.empty());
    if (measuring_) {
      bus.figures.violations += too_early ? 1 : 0;
      if (bus.answered && !too_early) {
        bus.figures.dead_time.add(at - bus.free_at);
      }
    }
  }
  bus.received.insert(bus.received.end(), bytes.begin(), bytes.end());
  if (bus.received.size() >= kRequestSize) {
    take_request(bus, at);
  }
}

void BusSimulator::take_request(Bus& bus, Moment at) {
  // A request that was written in one piece is on the wire from its first byte on; the wire is not
  // faster than its baud rate, and not faster than the other side writes.
  const Moment end = std::max(at, bus.began + plant_.characters(bus.received.size()));
  Frame response = answer(bus.number, bus.received);
  if (response.empty() && measuring_) {
    ++bus.figures.bad_frames;
  }
  if (!response.empty() && !plant_.answers(bus.received[0])) {
    response.clear();
  }
  bus.received.clear();
  bus.response = std::move(response);
  bus.sent = 0;
  bus.response_at = end + plant_.t3_5();
  bus.free_at = bus.response_at;
  bus.answered = false;
}

}  // namespace mbgate::bench
