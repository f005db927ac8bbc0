// SPDX-License-Identifier: Apache-2.0
// The result of a read or a write, as lines for people or as one JSON object.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <span>
#include <string>

#include "ctl/request/command.hpp"
#include "ctl/request/modbus_client.hpp"

namespace mbgate::ctl {

/// The values that were read: "30: 200000 (0x00030D40)" a line, or the plain values, or
/// {"unit":1,"table":"holding","values":[{"address":30,"value":200000}]}.
std::string read_report(const ReadCommand& command, std::span<const std::uint64_t> values);

/// "30: 200000 (0x00030D40) written" a line, or
/// {"unit":1,"table":"holding","address":30,"written":1}.
std::string write_report(const WriteCommand& command);

/// {"error":"...","exception":11}, the second only if an exception came.
std::string failure_json(const Failure& failure);

/// Prints a failure in words to `errors`, or as JSON to `out`. Returns its exit status.
int report_failure(const Failure& failure, bool as_json, std::ostream& out, std::ostream& errors);

}  // namespace mbgate::ctl
