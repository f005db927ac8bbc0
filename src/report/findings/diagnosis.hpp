// SPDX-License-Identifier: Apache-2.0
// The faults of the plant, as far as the gateway can know them. If several causes look alike, all
// of them are named. Parts that work are not mentioned.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "gateway/status/status_report.hpp"

namespace mbgate::report {

/// How bad it is, the worst first.
enum class Rank : std::uint8_t {
  nothing_works,  ///< on a whole line
  drive_lost,     ///< nothing is known of a drive
  bad_answers,    ///< answers come, but some are not what they should be, or cannot be trusted
  warning         ///< it may become worse, or is over
};

/// Something that is not well, and how that is known.
struct Diagnosis {
  Rank rank;
  std::string subject;   ///< "bus line-a", "device axis-x"
  std::string finding;   ///< what is wrong
  std::string evidence;  ///< the figures behind it
  std::string look_at;   ///< the key of the configuration, the cable, the drive
};

/// By rank, the worst first. Of one rank lines come before devices, because they explain what
/// devices do; then as in the report. Of a line first what explains the rest. Takes longer than the
/// report: not for the gateway's thread.
std::vector<Diagnosis> diagnose(const gateway::StatusReport& report);

}  // namespace mbgate::report
