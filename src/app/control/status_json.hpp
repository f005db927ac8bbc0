// SPDX-License-Identifier: Apache-2.0
// The status report as JSON (docs/api.yaml).
#pragma once

#include <boost/json/object.hpp>
#include <chrono>
#include <string>

#include "gateway/status/status_report.hpp"

namespace mbgate::app {

/// What the process knows beside the machine.
struct ProcessStatus {
  std::string version;
  std::string config;  ///< path of the configuration file
  std::chrono::system_clock::time_point config_read_at;
  bool reload_refused = false;  ///< the last one: the settings in force are older than the file
};

boost::json::object status_json(const gateway::StatusReport& report, const ProcessStatus& process);

}  // namespace mbgate::app
