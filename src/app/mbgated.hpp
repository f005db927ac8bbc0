// SPDX-License-Identifier: Apache-2.0
// The program mbgated from its arguments to its exit status.
#pragma once

#include <string>

namespace mbgate::app {

/// 0, 1 (it could not start or a fault of its own ended it), 64 (bad arguments), 73 (the recording
/// cannot be created) or 78 (bad configuration, or one that needs what this process may not do).
int run_mbgated(int argc, const char* const* argv, const std::string& version);

}  // namespace mbgate::app
