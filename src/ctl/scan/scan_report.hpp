// SPDX-License-Identifier: Apache-2.0
// What a scan found, for people.
#pragma once

#include <string>

#include "ctl/scan/scan.hpp"

namespace mbgate::ctl {

/// A table with a line for each unit, and below it what a reader must know of the words in it.
std::string scan_table(const ScanResult& result);

/// "moons-m3", or "moons-ssdc or moons-stb"; "generic" if no profile fits.
std::string likely_text(const Identification& identification);

/// Must be stated by the user: the drive can be set either way, and does not say how it is.
bool word_order_unknown(const Identification& identification);

}  // namespace mbgate::ctl
