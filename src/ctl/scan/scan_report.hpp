// SPDX-License-Identifier: Apache-2.0
// The result of a scan as text.
#pragma once

#include <string>

#include "ctl/scan/scan.hpp"

namespace mbgate::ctl {

/// A table with a line for each unit, and below it an explanation of the words in it.
std::string scan_table(const ScanResult& result);

/// "moons-m3", or "moons-ssdc or moons-stb"; "generic" if no profile fits.
std::string likely_text(const Identification& identification);

/// True if the user must state the word order: the drive can be set either way, and reading does
/// not show how it is set.
bool word_order_unknown(const Identification& identification);

}  // namespace mbgate::ctl
