// SPDX-License-Identifier: Apache-2.0
// Reads and checks the certificates of a configuration.
#pragma once

#include <string>
#include <vector>

#include "io/tls/tls_context.hpp"

namespace mbgate::io {

struct LoadedTls {
  /// Of the [[tls]] that listeners use; those that lines use alone are there for their dates.
  TlsContexts contexts;
  /// Why some are missing, with the name of their [[tls]]. Without `is_wrong` it may be mended by
  /// waiting.
  std::vector<std::string> failures;
  bool is_wrong = false;
  /// What ends soon, or has ended, and what is wrong for a line: one line each.
  std::vector<std::string> warnings;
};

enum class KeyCheck : bool { leave_out, ask_signer };

/// Reads files, and asks mbgate-signer: for a thread that may wait.
LoadedTls load_tls(const gateway::Settings& settings, KeyCheck keys);

/// What ends within 30 days, or has ended by now.
std::vector<std::string> warnings_of(const TlsContexts& contexts,
                                     std::chrono::system_clock::time_point now);

}  // namespace mbgate::io
