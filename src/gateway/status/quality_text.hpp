// SPDX-License-Identifier: Apache-2.0
// The text on the quality of the answers of a device or a line, with the figures behind it: for the
// journal as one sentence, for a diagnosis in its parts.
#pragma once

#include <string>

#include "bus/health/line_quality.hpp"

namespace mbgate::gateway {

/// "12 ms": milliseconds begun.
std::string milliseconds_text(bus::Duration duration);

/// Is there something to find? Not if all is well, or nothing is known.
[[nodiscard]] bool is_bad(const bus::QualityVerdict& verdict);

struct QualityFinding {
  std::string finding;
  std::string evidence;
  std::string look_at;
};

/// Of a verdict that is_bad().
QualityFinding quality_finding(const bus::QualityVerdict& verdict, bool is_of_line);

std::string quality_text(const bus::QualityNotice& notice);

}  // namespace mbgate::gateway
