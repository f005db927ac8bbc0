// SPDX-License-Identifier: Apache-2.0
// Carries `mbgatectl scan` out over a real connection.
#pragma once

#include <iosfwd>

#include "ctl/scan/scan.hpp"

namespace mbgate::ctl {

/// The table of what was found goes to `out`, and the configuration behind it or into its file,
/// which must not exist yet. Returns the exit status: kExitDone if anything was found.
int carry_out_scan(const ScanCommand& command, std::ostream& out, std::ostream& errors);

/// What the device or the gateway said, as the scan sees it.
Answer answer_of(const modbus::TableRange& read, const modbus::Pdu& response);

}  // namespace mbgate::ctl
