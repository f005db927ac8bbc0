// SPDX-License-Identifier: Apache-2.0
// What Prometheus collects (docs/metrics.md): the state of the gateway in its text format. Names
// and units follow its conventions. Labels are names of the configuration; units without a
// [[device]] are counted together.
#pragma once

#include <prometheus/metric_family.h>

#include <string>
#include <vector>

#include "app/metrics/process_status.hpp"
#include "gateway/status/status_report.hpp"

namespace mbgate::app {

/// `by_client`: requests by the addresses of clients too, which nothing bounds but the number of
/// connections.
std::vector<prometheus::MetricFamily> metric_families(const gateway::StatusReport& report,
                                                      const ProcessStatus& process, bool by_client);

/// Of the process that asks: what the kernel counts of it.
std::vector<prometheus::MetricFamily> process_families();

std::string metrics_text(const std::vector<prometheus::MetricFamily>& families);

}  // namespace mbgate::app
