// SPDX-License-Identifier: Apache-2.0
// What always holds (src/README.md), checked in every build. A machine in a state that its rules
// exclude no longer knows which client an answer belongs to. So it ends, and systemd starts a new
// one, which has no open requests.
#pragma once

#include <unistd.h>

#include <cstdio>
#include <cstdlib>

namespace mbgate {

/// Says on standard error which invariant is broken and where, and aborts.
[[noreturn, gnu::cold, gnu::noinline]] inline void fail_invariant(const char* invariant,
                                                                  const char* file, int line) {
  char text[256];
  const int size =
      std::snprintf(text, sizeof text, "broken invariant: %s (%s:%d)\n", invariant, file, line);
  const auto written = static_cast<std::size_t>(size) < sizeof text ? size : int{sizeof text} - 1;
  [[maybe_unused]] const auto ignored =
      ::write(STDERR_FILENO, text, static_cast<std::size_t>(written));
  std::abort();
}

}  // namespace mbgate

/// `invariant` says what must hold, in words of src/README.md.
#define MBGATE_ASSERT(condition, invariant) \
  ((condition) ? static_cast<void>(0) : ::mbgate::fail_invariant(invariant, __FILE__, __LINE__))
