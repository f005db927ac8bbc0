// SPDX-License-Identifier: Apache-2.0
// The drills: each makes its plant, and expects what the contract says of it.
#pragma once

#include "judge/drill.hpp"

namespace mbgate::judge {

void drill_room(Drill& drill, bool trace);
void drill_turns(Drill& drill, bool trace);
void drill_sharing(Drill& drill, bool trace);
void drill_quiet(Drill& drill, bool trace);

}  // namespace mbgate::judge
