// SPDX-License-Identifier: Apache-2.0
// Identifies the units of a bus, one after the other. Only functions 01 to 04 are used: a scan
// never writes.
//
// To change
// - the modes that a scan of a serial port tries, and its end: sweep (pure), port_scan (with the
//   port); the bytes that were heard: ctl/serial/heard; other users of the port:
//   ctl/serial/serial_port.
// - how a scan tells drives apart: candidate (what a profile predicts), identifier (what to ask
//   next).
#pragma once

#include <functional>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "ctl/request/command.hpp"
#include "ctl/scan/identifier.hpp"
#include "ctl/serial/serial_port.hpp"

namespace mbgate::ctl {

/// A unit that answered.
struct FoundUnit {
  std::uint8_t unit;
  Identification identification;
  std::chrono::nanoseconds slowest;  ///< of its answers, as seen by the scan
  bool fell_silent = false;          ///< several reads were unanswered: no further ones were sent
};

struct ScanResult {
  std::vector<FoundUnit> found;
  std::vector<std::uint8_t> busy;    ///< units whose first read got only "busy", repeated or not
  bool any_way = false;              ///< some unit had a route: not every read got no_way
  std::optional<std::string> error;  ///< why the scan ended early
};

/// One read of one unit. An error ends the scan.
using AskUnit = std::function<Result<Answer, std::string>(std::uint8_t, const modbus::TableRange&)>;
/// Called before each unit.
using Progress = std::function<void(std::uint8_t unit, std::size_t found)>;

ScanResult scan_units(const std::vector<std::uint8_t>& units, const Catalogue& catalogue,
                      const AskUnit& ask, const Progress& progress);

/// The answer of the device or of the gateway, as the scan classifies it.
Answer answer_of(const modbus::TableRange& read, const modbus::Pdu& response);

/// "1-32", "1,5,17-20": units 1 to 254. The result is in ascending order, each unit once. The error
/// is a full sentence.
Result<std::vector<std::uint8_t>, std::string> parse_units(std::string_view text);

/// A serial port, and the mode in which its units answered.
struct FoundLine {
  std::string device;
  std::optional<std::string> lasting_name{};  ///< another path to it, in /dev/serial/by-id
  LineMode mode{};
};

struct PortScan {
  ScanResult result{};
  std::optional<FoundLine> line{};   ///< the mode in which units answered
  std::vector<std::string> notes{};  ///< what else was heard: a sentence each
};

/// Scans the line at a serial port, without a gateway: finds the mode, then identifies the units.
/// `command` has a port. Says on `errors` how long it takes at most, and how far it is. SIGINT and
/// SIGTERM end it with what was found.
PortScan scan_port(const ScanCommand& command, const Catalogue& catalogue, std::ostream& errors);

}  // namespace mbgate::ctl
