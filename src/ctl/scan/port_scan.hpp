// SPDX-License-Identifier: Apache-2.0
// Scans the line at a serial port, without a gateway: finds the mode, then identifies the units.
#pragma once

#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "ctl/scan/scan.hpp"
#include "ctl/scan/starting_config.hpp"

namespace mbgate::ctl {

struct PortScan {
  ScanResult result{};
  std::optional<FoundLine> line{};   ///< the mode in which units answered
  std::vector<std::string> notes{};  ///< what else was heard: a sentence each
};

/// `command` has a port. Says on `errors` how long it takes at most, and how far it is. SIGINT and
/// SIGTERM end it with what was found.
PortScan scan_port(const ScanCommand& command, const Catalogue& catalogue, std::ostream& errors);

}  // namespace mbgate::ctl
