// SPDX-License-Identifier: Apache-2.0
#include "sim/simulator.hpp"

#include <poll.h>
#include <sys/signalfd.h>
#include <sys/timerfd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <ostream>

namespace mbgate::sim {
namespace {

// How soon after its client has gone a port can be opened again by somebody who is not root.
constexpr std::chrono::duration<int, std::milli> kExclusiveCheck{200};

// The steady clock is CLOCK_MONOTONIC, so instants can be given to the timer as they are.
Instant now() { return Instant(std::chrono::steady_clock::now().time_since_epoch()); }

sigset_t handled_signals() {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : {SIGTERM, SIGINT, SIGUSR1, SIGUSR2}) {
    sigaddset(&set, signal);
  }
  return set;
}

}  // namespace

Simulator::Simulator(const Settings& settings, std::ostream& output, std::ostream& errors)
    : reopen_after_(settings.reopen_after), output_(output), errors_(errors) {
  for (const BusSettings& bus : settings.buses) {
    buses_.emplace_back(bus);
  }
}

int Simulator::run() {
  if (!prepare() || !connect()) {
    return 1;
  }
  while (!stopping_ && !failed_) {
    serve_once();
  }
  disconnect();
  print_counters();
  return failed_ ? 1 : 0;
}

bool Simulator::prepare() {
  const sigset_t set = handled_signals();
  std::signal(SIGPIPE, SIG_IGN);
  ::pthread_sigmask(SIG_BLOCK, &set, nullptr);
  signals_.reset(::signalfd(-1, &set, SFD_NONBLOCK | SFD_CLOEXEC));
  timer_.reset(::timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC));
  if (signals_.get() < 0 || timer_.get() < 0) {
    errors_ << "mbgate-sim: the system gives no signalfd or timerfd\n";
    return false;
  }
  return true;
}

bool Simulator::connect() {
  for (LiveBus& bus : buses_) {
    if (const auto error = bus.connect()) {
      errors_ << "mbgate-sim: " << *error << '\n';
      failed_ = true;
      return false;
    }
    output_ << bus.introduction() << '\n';
  }
  output_ << "ready\n" << std::flush;
  connected_ = true;
  return true;
}

void Simulator::disconnect() {
  for (LiveBus& bus : buses_) {
    bus.disconnect();
  }
  connected_ = false;
}

void Simulator::serve_once() {
  arm_timer();
  wait();
  const Instant instant = now();
  if (reopen_at_ && instant >= *reopen_at_) {
    reopen_at_.reset();
    connect();
  }
  for (LiveBus& bus : buses_) {
    bus.handle_time(instant);
  }
  if (instant >= release_at_) {
    release_exclusive();
    release_at_ = instant + kExclusiveCheck;
  }
}

void Simulator::release_exclusive() {
  for (const LiveBus& bus : buses_) {
    if (bus.pty() != nullptr) {
      bus.pty()->release_exclusive();
    }
  }
}

void Simulator::arm_timer() {
  const auto next = next_event();
  if (next == armed_for_) {
    return;
  }
  armed_for_ = next;
  itimerspec when{};
  if (next) {
    const auto nanoseconds = std::max(next->time_since_epoch(), Duration{1}).count();
    when.it_value.tv_sec = nanoseconds / 1'000'000'000;
    when.it_value.tv_nsec = nanoseconds % 1'000'000'000;
  }
  ::timerfd_settime(timer_.get(), TFD_TIMER_ABSTIME, &when, nullptr);
}

void Simulator::wait() {
  std::vector<pollfd> waiting{{signals_.get(), POLLIN, 0}, {timer_.get(), POLLIN, 0}};
  for (const LiveBus& bus : buses_) {
    waiting.push_back({bus.pty() != nullptr ? bus.pty()->descriptor() : -1, POLLIN, 0});
  }
  ::poll(waiting.data(), waiting.size(), kExclusiveCheck.count());
  if ((waiting[1].revents & POLLIN) != 0) {
    std::uint64_t expirations = 0;
    if (::read(timer_.get(), &expirations, sizeof expirations) > 0) {
      armed_for_.reset();
    }
  }
  for (std::size_t i = 0; i < buses_.size(); ++i) {
    if ((waiting[i + 2].revents & POLLIN) != 0) {
      buses_[i].handle_readable(now());
    }
  }
  if ((waiting[0].revents & POLLIN) != 0) {
    handle_signal();
  }
}

void Simulator::handle_signal() {
  signalfd_siginfo info{};
  while (::read(signals_.get(), &info, sizeof info) == static_cast<ssize_t>(sizeof info)) {
    if (info.ssi_signo == SIGUSR1) {
      print_counters();
    } else if (info.ssi_signo == SIGUSR2) {
      disconnect();
      reopen_at_ = now() + reopen_after_;
    } else {
      stopping_ = true;
    }
  }
}

void Simulator::print_counters() {
  for (const LiveBus& bus : buses_) {
    output_ << bus.counters_text() << '\n';
  }
  output_ << std::flush;
}

std::optional<Instant> Simulator::next_event() const {
  std::optional<Instant> next = reopen_at_;
  for (const LiveBus& bus : buses_) {
    next = bus::earlier(next, bus.next_event());
  }
  return next;
}

}  // namespace mbgate::sim
