// SPDX-License-Identifier: Apache-2.0
// mbgate-sim: virtual RS-485 buses with drives on them, each on a pty or a TCP port. Exit status 0
// stopped or valid, 1 the system refused something, 64 wrong usage, 78 the configuration is wrong.
#include <sysexits.h>

#include <CLI/CLI.hpp>
#include <iostream>

#include "config/diagnostic.hpp"
#include "sim/program/simulator.hpp"
#include "sys/unique_fd.hpp"

namespace {

constexpr auto kFooter = R"text(
When the buses are ready, one line each is printed, "bus NAME LINK (/dev/pts/N)" or
"bus NAME ADDRESS:PORT", then "ready".

Signals:
  SIGTERM, SIGINT  print the counters, remove the links and end
  SIGUSR1          print the counters of each bus
  SIGUSR2          close all ptys and sockets, as if adapters and cables were pulled out, and make them
                   again after `reopen_after` (default 1s); the drives keep their state
)text";

}  // namespace

int main(int argc, char** argv) {
  mbgate::sys::open_standard_streams();
  CLI::App app(
      "Simulates RS-485 buses with drives, each on a pseudo-terminal or a TCP port, at the speed "
      "of the wire.");
  std::string path;
  bool check = false;
  app.add_option("CONFIG", path, "the simulator's configuration, such as conf/demo-sim.toml")
      ->required();
  app.add_flag("--check", check, "only validate the configuration; make nothing");
  app.set_version_flag("--version", "mbgate-sim " MBGATE_VERSION);
  app.footer(kFooter);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : EX_USAGE;
  }
  const auto loaded = mbgate::sim::load_settings(mbgate::config::read_text_file(path));
  std::cerr << mbgate::config::render(loaded.diagnostics);
  if (!loaded.settings) {
    return EX_CONFIG;
  }
  if (check) {
    std::cout << path << ": valid\n";
    return 0;
  }
  return mbgate::sim::Simulator(*loaded.settings, std::cout, std::cerr).run();
}
