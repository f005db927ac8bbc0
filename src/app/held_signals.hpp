// SPDX-License-Identifier: Apache-2.0
// Holds signals that arrive while the process starts. A SIGHUP then must not end the gateway; it
// leads to a reload as soon as the gateway serves.
#pragma once

namespace mbgate::app {

/// To be called first, on the only thread: from now on a SIGHUP waits. What other daemons take for
/// "tell" or "reopen your log", SIGUSR1 and SIGUSR2, is ignored, and so is what write() tells too:
/// that nobody reads any more, or that a file may not grow.
void hold_signals();
/// Somebody waits for SIGHUP now: one that came since hold_signals() comes now.
void release_held_signals();

}  // namespace mbgate::app
