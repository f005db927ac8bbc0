// SPDX-License-Identifier: Apache-2.0
// The parts that a plan is drawn in.
#pragma once

#include "world/plan.hpp"

namespace mbgate::world {

/// What the settings say of a drive that has the registers of world/registers.hpp.
void draw_profile(drive::Device& device, bool is_tcp, Random& random);
/// Listeners, routes, and the doors that they make.
void draw_doors(Plan& plan, Random& random);
/// Who may write to a device, and what is written when everybody has gone.
void draw_guards(Plan& plan, Random& random);
void draw_clients(Plan& plan, Random& random);

}  // namespace mbgate::world
