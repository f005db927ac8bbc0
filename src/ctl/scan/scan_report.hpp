// SPDX-License-Identifier: Apache-2.0
// The result of a scan as text, and as JSON.
#pragma once

#include <optional>
#include <string>

#include "ctl/scan/scan.hpp"

namespace mbgate::ctl {

/// A table with a line for each unit, and below it an explanation of the words in it.
std::string scan_table(const ScanResult& result);

/// What stands above the table of a serial port: "/dev/ttyUSB0, 9600 baud, parity even, stop bits
/// 1:" and the end of the line.
std::string line_head(const FoundLine& line);

/// True if the user must state the word order: the drive can be set either way, and reading does
/// not show how it is set.
bool word_order_unknown(const Identification& identification);

/// One JSON object: "units" (what scan_table() says of each), "busy" (units that were not scanned),
/// "configuration" (null if no unit was found), and "error" if there is one; `of_port`: also "line"
/// (its mode; null if no unit answered) and "notes".
std::string scan_json(const PortScan& scan, bool of_port,
                      const std::optional<std::string>& configuration,
                      const std::optional<std::string>& error);

// A configuration to start from, for the bus as a scan found it. `mbgated --check` accepts it as it
// is. What reading cannot show is left as a comment to choose from, never guessed: with a wrong
// word order an axis would move to another position.

/// `bus` is the name that the bus gets.
std::string starting_config(const Target& target, const std::string& bus,
                            const std::vector<FoundUnit>& found);
std::string starting_config(const FoundLine& line, const std::string& bus,
                            const std::vector<FoundUnit>& found);

}  // namespace mbgate::ctl
