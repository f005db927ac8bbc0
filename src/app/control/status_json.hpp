// SPDX-License-Identifier: Apache-2.0
// The status report as JSON (docs/api.yaml).
#pragma once

#include <boost/json/object.hpp>

#include "app/metrics/metrics.hpp"
#include "gateway/status/status_report.hpp"

namespace mbgate::app {

boost::json::object status_json(const gateway::StatusReport& report, const ProcessStatus& process);

}  // namespace mbgate::app
