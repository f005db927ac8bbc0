// SPDX-License-Identifier: Apache-2.0
// What the process knows beside the machine.
#pragma once

#include <chrono>
#include <string>

namespace mbgate::app {

struct ProcessStatus {
  std::string version;
  std::string config;  ///< path of the configuration file
  std::chrono::system_clock::time_point config_read_at;
  bool reload_refused = false;  ///< the last one: the settings in force are older than the file
};

}  // namespace mbgate::app
