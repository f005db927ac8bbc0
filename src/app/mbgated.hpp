// SPDX-License-Identifier: Apache-2.0
// The program mbgated from its arguments to its exit status, and the signals that it begins with.
#pragma once

#include <string>

namespace mbgate::app {

/// 0, 1 (it could not start or a fault of its own ended it), 64 (bad arguments), 73 (the recording
/// cannot be created) or 78 (bad configuration, or one that needs what this process may not do).
int run_mbgated(int argc, const char* const* argv, const std::string& version);

// Holds signals that arrive while the process starts. A SIGHUP then must not end the gateway; it
// leads to a reload as soon as the gateway serves.

/// To be called first, on the only thread: from now on a SIGHUP waits. What other daemons take for
/// "tell" or "reopen your log", SIGUSR1 and SIGUSR2, is ignored, and so is what write() tells too:
/// that nobody reads any more, or that a file may not grow.
void hold_signals();
/// Somebody waits for SIGHUP now: one that came since hold_signals() comes now.
void release_held_signals();

}  // namespace mbgate::app
