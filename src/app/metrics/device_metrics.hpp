// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "app/metrics/metric_book.hpp"
#include "gateway/status/status_report.hpp"

namespace mbgate::app {

/// Addresses of a bus that no [[device]] names are one, "other", without an address.
void add_devices(MetricBook& book, const gateway::StatusReport& report);

void add_bus(MetricBook& book, const gateway::BusStatus& bus);

}  // namespace mbgate::app
