// SPDX-License-Identifier: Apache-2.0
#include "app/command_line.hpp"

#include <sysexits.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <iostream>

#include "config/keys/keys.hpp"

namespace mbgate::app {

std::variant<Options, int> parse_command_line(int argc, const char* const* argv,
                                              const std::string& version) {
  Options options;
  CLI::App app("mbgated: carries Modbus TCP requests to devices on serial lines", "mbgated");
  app.add_option("--config", options.config, "The configuration file")
      ->type_name("FILE")
      ->capture_default_str();
  app.add_option("--profiles", options.profiles,
                 "Look for drive profiles in this folder only (instead of [gateway] profiles, or "
                 "/etc/mbgate/profiles and the installed ones)")
      ->type_name("DIR")
      ->check(CLI::ExistingDirectory);
  app.add_option(
         "--record", options.record,
         "Record everything that clients and lines say to this file, in the service's state "
         "directory if it has one; it grows as long as mbgated runs")
      ->type_name("FILE");
  app.add_flag("--check", options.check,
               "Validate the configuration without touching a port, then exit");
  bool keys = false;
  app.add_flag("--keys", keys,
               "Print what each plain key of the configuration takes: section, key, range, default "
               "and where it belongs, separated by tabs; then exit");
  app.set_version_flag("--version", "mbgated " + version);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == EXIT_SUCCESS ? EXIT_SUCCESS : EX_USAGE;
  }
  if (keys) {
    std::cout << config::list_keys();
    return EXIT_SUCCESS;
  }
  return options;
}

}  // namespace mbgate::app
