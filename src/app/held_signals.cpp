// SPDX-License-Identifier: Apache-2.0
#include "app/held_signals.hpp"

#include <csignal>
#include <initializer_list>

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
  for (const int ignored : {SIGPIPE, SIGUSR1, SIGUSR2, SIGXFSZ}) {
    std::signal(ignored, SIG_IGN);
  }
  change_mask(SIG_BLOCK);
}

void release_held_signals() { change_mask(SIG_UNBLOCK); }

}  // namespace mbgate::app
