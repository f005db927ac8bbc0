// SPDX-License-Identifier: Apache-2.0
// One plant before its judges: faults, then rest, then the end.
#pragma once

#include <functional>

#include "world/world.hpp"

namespace mbgate::judge {

struct Course {
  std::uint64_t transactions = 500;  ///< that are seen before faults stop
  bool trace = false;
  std::function<void(world::World&)> prepare = [](world::World&) {};
};

/// What was seen; what is thrown is a violation too.
world::Report run(world::Plan plan, const Course& course);

/// What is fast enough, in plants that are made for it, at the product's default times: prints each
/// figure with the bound that the contract wants. False: one is out that is kept today.
bool run_bounds();

}  // namespace mbgate::judge
