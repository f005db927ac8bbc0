// SPDX-License-Identifier: Apache-2.0
// What is wrong with the plant, as far as the gateway can know it. Where causes look alike, all of
// them are named. What works is not mentioned.
#pragma once

#include <vector>

#include "gateway/status/status_report.hpp"

namespace mbgate::gateway {

/// Lines before devices, because they explain what devices do; then as in the report. The report's
/// own diagnoses are not looked at.
std::vector<Diagnosis> diagnose(const StatusReport& report);

}  // namespace mbgate::gateway
