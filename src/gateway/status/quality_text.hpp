// SPDX-License-Identifier: Apache-2.0
// The text on the quality of the answers of a device or a line, with the figures behind it: for the
// journal as one sentence, for a diagnosis in its parts.
#pragma once

#include <string>

#include "bus/health/line_quality.hpp"

namespace mbgate::gateway {

struct QualityFinding {
  std::string finding;
  std::string evidence;
  std::string look_at;
};

/// Of a verdict other than unknown and good.
QualityFinding quality_finding(const bus::QualityVerdict& verdict, bool is_of_line);

std::string quality_text(const bus::QualityNotice& notice);

}  // namespace mbgate::gateway
