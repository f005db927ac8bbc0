// SPDX-License-Identifier: Apache-2.0
// The result of a scan for programs.
#pragma once

#include <optional>
#include <string>

#include "ctl/scan/port_scan.hpp"

namespace mbgate::ctl {

/// One JSON object: "units" (what scan_table() says of each), "busy" (units that were not scanned),
/// "configuration" (null if no unit was found), and "error" if there is one.
std::string scan_json(const ScanResult& result, const std::optional<std::string>& configuration,
                      const std::optional<std::string>& error);
/// The same of a serial port; also "line" (its mode; null if no unit answered) and "notes".
std::string scan_json(const PortScan& scan, const std::optional<std::string>& configuration,
                      const std::optional<std::string>& error);

}  // namespace mbgate::ctl
