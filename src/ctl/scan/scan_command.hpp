// SPDX-License-Identifier: Apache-2.0
// Runs `mbgatectl scan` over a real connection, or at a serial port.
#pragma once

#include <iosfwd>

#include "ctl/scan/scan.hpp"

namespace mbgate::ctl {

/// Prints the table of what was found to `out`. The configuration follows it there, or is written
/// to a file, which must not exist yet. With --json both are one JSON object, errors included.
/// Returns the exit status: kExitDone if anything was found.
int carry_out_scan(const ScanCommand& command, std::ostream& out, std::ostream& errors);

/// The answer of the device or of the gateway, as the scan classifies it.
Answer answer_of(const modbus::TableRange& read, const modbus::Pdu& response);

}  // namespace mbgate::ctl
