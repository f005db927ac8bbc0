// SPDX-License-Identifier: Apache-2.0
// Findings about the line from the answers of all units together: whether it has an echo, and
// whether two devices have one address.
#pragma once

#include <optional>
#include <vector>

#include "ctl/doctor/finding.hpp"
#include "ctl/doctor/trial.hpp"

namespace mbgate::ctl {

/// Of what came before anything was sent, or else between two requests; nothing where that is of no
/// importance.
std::optional<Finding> foreign_finding(const Unasked& before, const std::vector<UnitTrials>& units);

/// Each of the units was asked at least once.
Finding echo_finding(const LinePlan& plan, const std::vector<UnitTrials>& units);

/// Nothing is claimed that another cause could explain as well.
Finding addresses_finding(const std::vector<UnitTrials>& units);

// What is to be said of how well and how soon each unit answers. Where causes look alike, all of
// them are named.

/// One for each unit, in their order. Each was asked at least once.
std::vector<Finding> answer_findings(const LinePlan& plan, const std::vector<UnitTrials>& units);

}  // namespace mbgate::ctl
