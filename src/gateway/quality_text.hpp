// SPDX-License-Identifier: Apache-2.0
// The journal's text on the quality of the answers of a device or a line, with the figures behind
// it.
#pragma once

#include <string>

#include "bus/health/line_quality.hpp"

namespace mbgate::gateway {

std::string quality_text(const bus::QualityNotice& notice);

}  // namespace mbgate::gateway
