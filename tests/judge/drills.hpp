// SPDX-License-Identifier: Apache-2.0
// The drills: each makes its plant, and expects what the contract says of it.
#pragma once

#include "judge/drill.hpp"

namespace mbgate::judge {

void drill_silence(Drill& drill, bool trace);
void drill_damage(Drill& drill, bool trace);
void drill_lateness(Drill& drill, bool trace);
void drill_hold(Drill& drill, bool trace);
void drill_seconds(Drill& drill, bool trace);
void drill_room(Drill& drill, bool trace);
void drill_turns(Drill& drill, bool trace);
void drill_sharing(Drill& drill, bool trace);
void drill_quiet(Drill& drill, bool trace);
void drill_noise(Drill& drill, bool trace);
void drill_crawl(Drill& drill, bool trace);
void drill_misfits(Drill& drill, bool trace);
void drill_stranger(Drill& drill, bool trace);
void drill_stop_first(Drill& drill, bool trace);
void drill_stop_fails(Drill& drill, bool trace);
void drill_old_echo(Drill& drill, bool trace);
void drill_reload(Drill& drill, bool trace);
void drill_failsafe(Drill& drill, bool trace);

}  // namespace mbgate::judge
