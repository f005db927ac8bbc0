// SPDX-License-Identifier: Apache-2.0
#include "app/held_signals.hpp"

#include <csignal>

namespace mbgate::app {
namespace {

void change_mask(int how) {
  sigset_t held;
  sigemptyset(&held);
  sigaddset(&held, SIGHUP);
  ::pthread_sigmask(how, &held, nullptr);
}

}  // namespace

void hold_signals() {
  std::signal(SIGUSR1, SIG_IGN);
  std::signal(SIGUSR2, SIG_IGN);
  change_mask(SIG_BLOCK);
}

void release_held_signals() { change_mask(SIG_UNBLOCK); }

}  // namespace mbgate::app
