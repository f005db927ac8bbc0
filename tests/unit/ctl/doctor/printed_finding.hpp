// SPDX-License-Identifier: Apache-2.0
// How a test shows a finding that is not the expected one.
#pragma once

#include <ostream>

#include "ctl/doctor/findings.hpp"

namespace mbgate::ctl {

// NOLINTNEXTLINE(readability-identifier-naming): the library calls it so
inline void PrintTo(const Finding& finding, std::ostream* out) { *out << finding_line(finding); }

}  // namespace mbgate::ctl
