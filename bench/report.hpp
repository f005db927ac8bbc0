// SPDX-License-Identifier: Apache-2.0
// What is printed and written of all runs.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "run.hpp"

namespace mbgate::bench {

/// A contestant and its runs, in the order of the pairs.
struct Contest {
  Scenario scenario;
  std::vector<RunResult> runs;
};

/// The median of each figure over the runs, a column a contestant; where there are several, also
/// the median over the pairs of what each has against the first.
void print_table(std::ostream& out, const std::vector<Contest>& contests);

/// The same and each single run, as JSON.
std::string to_json(const std::vector<Contest>& contests, const std::vector<std::string>& command);

}  // namespace mbgate::bench
