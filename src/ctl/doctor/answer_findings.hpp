// SPDX-License-Identifier: Apache-2.0
// What is to be said of how well and how soon each unit answers. Where causes look alike, all of
// them are named.
#pragma once

#include <vector>

#include "ctl/doctor/finding.hpp"
#include "ctl/doctor/trial.hpp"

namespace mbgate::ctl {

/// One for each unit, in their order. Each was asked at least once.
std::vector<Finding> answer_findings(const LinePlan& plan, const std::vector<UnitTrials>& units);

}  // namespace mbgate::ctl
