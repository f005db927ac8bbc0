// SPDX-License-Identifier: Apache-2.0
// What an operator must know of a write: that it ended half-way, or that it changed how the drive
// can be reached.
#pragma once

#include "gateway/exchanges/exchange.hpp"
#include "gateway/reports.hpp"

namespace mbgate::gateway {

/// To be called when a job has ended. The settings are those in which the job's bus has its number.
void report_effects(const Exchange& exchange, const Exchange::Part& part, bus::Ending ending,
                    const Settings& settings, ActionQueue& actions);

}  // namespace mbgate::gateway
