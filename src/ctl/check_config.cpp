// SPDX-License-Identifier: Apache-2.0
#include "ctl/check_config.hpp"

#include <ostream>

#include "config/check_summary.hpp"
#include "config/load.hpp"
#include "ctl/request/carry_out.hpp"

namespace mbgate::ctl {

int check_config(const CheckCommand& command, std::ostream& out, std::ostream& errors) {
  const auto loaded = config::load_settings(command.config, {.folder = command.folder});
  errors << config::render(loaded.diagnostics) << std::flush;
  if (!loaded.settings) {
    return kExitConfiguration;
  }
  out << config::check_summary(*loaded.settings) << '\n';
  return kExitDone;
}

}  // namespace mbgate::ctl
