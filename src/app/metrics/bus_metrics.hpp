// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "app/metrics/metric_book.hpp"
#include "gateway/status/status_report.hpp"

namespace mbgate::app {

void add_bus(MetricBook& book, const gateway::BusStatus& bus);

}  // namespace mbgate::app
