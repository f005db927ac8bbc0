// SPDX-License-Identifier: Apache-2.0
#include "sim/program/simulator.hpp"

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
    if (bus.mode == BusMode::tcp) {
      buses_.emplace_back(std::in_place_type<LiveTcpBus>, bus);
    } else {
      buses_.emplace_back(std::in_place_type<LiveBus>, bus);
    }
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
    errors_ << "mbgate-sim: the system provides no signalfd or timerfd\n";
    return false;
  }
  return true;
}

bool Simulator::connect() {
  for (AnyBus& any : buses_) {
    const auto error = std::visit([](auto& bus) { return bus.connect(); }, any);
    if (error) {
      errors_ << "mbgate-sim: " << *error << '\n';
      failed_ = true;
      return false;
    }
    output_ << std::visit([](const auto& bus) { return bus.introduction(); }, any) << '\n';
  }
  output_ << "ready\n" << std::flush;
  return true;
}

void Simulator::disconnect() {
  for (AnyBus& any : buses_) {
    std::visit([](auto& bus) { bus.disconnect(); }, any);
  }
}

void Simulator::serve_once() {
  arm_timer();
  wait();
  const Instant instant = now();
  if (reopen_at_ && instant >= *reopen_at_) {
    reopen_at_.reset();
    connect();
  }
  for (AnyBus& any : buses_) {
    std::visit([instant](auto& bus) { bus.handle_time(instant); }, any);
  }
  if (instant >= release_at_) {
    release_exclusive();
    release_at_ = instant + kExclusiveCheck;
  }
}

void Simulator::release_exclusive() {
  for (const AnyBus& any : buses_) {
    std::visit([](const auto& bus) { bus.release_exclusive(); }, any);
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
    when.it_value = sys::timespec_of(std::max(next->time_since_epoch(), Duration{1}));
  }
  ::timerfd_settime(timer_.get(), TFD_TIMER_ABSTIME, &when, nullptr);
}

void Simulator::wait() {
  std::vector<pollfd> waiting{{signals_.get(), POLLIN, 0}, {timer_.get(), POLLIN, 0}};
  std::vector<AnyBus*> owners{nullptr, nullptr};
  for (AnyBus& any : buses_) {
    for (const int descriptor : std::visit([](auto& bus) { return bus.descriptors(); }, any)) {
      waiting.push_back({descriptor, POLLIN, 0});
      owners.push_back(&any);
    }
  }
  ::poll(waiting.data(), waiting.size(), kExclusiveCheck.count());
  if ((waiting[1].revents & POLLIN) != 0) {
    handle_timer();
  }
  for (std::size_t i = 2; i < waiting.size(); ++i) {
    if (waiting[i].revents != 0) {
      std::visit([](auto& bus) { bus.handle_readable(now()); }, *owners[i]);
    }
  }
  if ((waiting[0].revents & POLLIN) != 0) {
    handle_signal();
  }
}

void Simulator::handle_timer() {
  std::uint64_t expirations = 0;
  if (::read(timer_.get(), &expirations, sizeof expirations) > 0) {
    armed_for_.reset();
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
  for (const AnyBus& any : buses_) {
    output_ << std::visit([](const auto& bus) { return bus.counters_text(); }, any) << '\n';
  }
  output_ << std::flush;
}

std::optional<Instant> Simulator::next_event() const {
  std::optional<Instant> next = reopen_at_;
  for (const AnyBus& any : buses_) {
    next = bus::earlier(next, std::visit([](const auto& bus) { return bus.next_event(); }, any));
  }
  return next;
}

}  // namespace mbgate::sim
