// SPDX-License-Identifier: Apache-2.0
#include "app/mbgated.hpp"

#include <sysexits.h>

#include <chrono>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <utility>
#include <variant>

#include "app/command_line.hpp"
#include "app/log.hpp"
#include "app/service.hpp"
#include "app/text.hpp"
#include "config/load.hpp"

namespace mbgate::app {
namespace {

/// The last lines have this long to be written; a standard error that nobody reads must not keep
/// the process.
constexpr std::chrono::milliseconds kLogFlush{150};

int serve(gateway::Settings settings) {
  Log log(is_standard_error_the_journal());
  int status = EXIT_FAILURE;
  try {
    Service service(std::move(settings), log);
    status = service.run();
  } catch (const std::exception& exception) {
    log.write(Level::error, std::string("fatal: ") + exception.what());
  }
  if (!log.flush(kLogFlush)) {
    std::_Exit(status);
  }
  return status;
}

}  // namespace

int run_mbgated(int argc, const char* const* argv, const std::string& version) {
  const auto parsed = parse_command_line(argc, argv, version);
  if (const int* const status = std::get_if<int>(&parsed)) {
    return *status;
  }
  const auto& options = std::get<Options>(parsed);
  config::Loaded loaded = config::load_settings(options.config, {.folder = options.profiles});
  std::cerr << config::render(loaded.diagnostics) << std::flush;
  if (!loaded.settings) {
    return EX_CONFIG;
  }
  if (options.check) {
    std::cout << check_summary(*loaded.settings) << '\n';
    return EXIT_SUCCESS;
  }
  return serve(*std::move(loaded.settings));
}

}  // namespace mbgate::app
