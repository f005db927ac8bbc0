// SPDX-License-Identifier: Apache-2.0
// What is said of a device's or a line's answers, with what it rests on.
#pragma once

#include <string>

#include "bus/health/line_quality.hpp"

namespace mbgate::gateway {

std::string quality_text(const bus::QualityNotice& notice);

}  // namespace mbgate::gateway
