// SPDX-License-Identifier: Apache-2.0
// mbgate-bench: what a gateway makes of a wire. README.md says how it measures, and what.
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include "contestant.hpp"
#include "report.hpp"

namespace {

namespace fs = std::filesystem;
using namespace mbgate::bench;  // NOLINT(google-build-using-namespace): this is its program

struct Options {
  std::vector<std::string> contestants;
  std::vector<std::string> commands;
  Scenario common;
  double seconds = 5;
  double warm_up = 1;
  unsigned pairs = 1;
  fs::path mbgated;
  fs::path json;
  bool allocations = false;
};

Nanoseconds to_duration(double seconds) {
  return Nanoseconds(static_cast<std::int64_t>(seconds * 1e9));
}

void declare(CLI::App& app, Options& options) {
  Plant& plant = options.common.plant;
  LoadSettings& load = options.common.load;
  app.add_option(
         "contestant", options.contestants,
         "mbgated, master (a bare master without TCP), relay (a relay that looks at nothing) "
         "or a name given by --command; with its own options behind a colon, as in "
         "mbgated:buses=16,devices=8")
      ->required();
  app.add_option("--command", options.commands,
                 "NAME=COMMAND: another gateway; {device}, {baud} and {port} (on 127.0.0.1) are "
                 "filled in, with TLS also {certificate}, {key} and {authorities}");
  app.add_option("--baud", plant.baud, "baud rate of the lines; 0: bytes take no time")
      ->capture_default_str();
  app.add_option("--buses", plant.buses, "buses of the gateway")->capture_default_str();
  app.add_option("--devices", plant.devices, "devices on each bus")->capture_default_str();
  app.add_option("--dead", plant.dead, "how many of the devices never answer")
      ->capture_default_str();
  app.add_option("--registers", plant.registers, "registers that each request reads")
      ->capture_default_str();
  app.add_option("--clients", load.clients,
                 "clients, each of which asks again as soon as it is answered")
      ->capture_default_str();
  app.add_option("--outstanding", load.outstanding, "unanswered requests of each client")
      ->capture_default_str();
  app.add_flag("--same", load.same, "have all clients read the same registers of a device");
  app.add_option("--idle", load.idle, "additional connections that send nothing")
      ->capture_default_str();
  app.add_option("--flood", load.flood,
                 "connections that send garbage without end to another listener of mbgated")
      ->capture_default_str();
  app.add_flag("--tls", load.tls, "connect the clients over TLS");
  app.add_option("--handshakes", load.handshakes,
                 "processes that shake hands over TLS without end, at another listener of mbgated")
      ->capture_default_str();
  app.add_flag("--coalesce,!--no-coalesce", options.common.coalesce, "mbgated's key")
      ->capture_default_str();
  app.add_option("--wake-early", options.common.wake_early, "mbgated's key, in microseconds")
      ->capture_default_str();
  app.add_option("--seconds", options.seconds, "how long each run is measured")
      ->check(CLI::Range(0.05, 600.0))
      ->capture_default_str();
  app.add_option("--warm-up", options.warm_up,
                 "how long each run goes before it is measured, in seconds")
      ->check(CLI::Range(0.0, 600.0))
      ->capture_default_str();
  app.add_option("--pairs", options.pairs, "how often each contestant runs, in turn")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--mbgated", options.mbgated,
                 "the program; default: beside this one, or as installed");
  app.add_flag("--allocations", options.allocations, "count how often mbgated allocates memory");
  app.add_option("--json", options.json, "write all figures to this file");
}

/// A folder that is gone with its owner.
class WorkFolder {
 public:
  WorkFolder() {
    std::string name = (fs::temp_directory_path() / "mbgate-bench.XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) {
      throw std::runtime_error("no folder for temporary files at " + name);
    }
    path_ = name;
  }
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;
  ~WorkFolder() {
    std::error_code error;
    fs::remove_all(path_, error);
  }
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

/// As many files as the kernel lets us have: 10,000 clients are 10,000 of them.
void want_many_files() {
  rlimit limit{};
  ::getrlimit(RLIMIT_NOFILE, &limit);
  limit.rlim_cur = limit.rlim_max;
  ::setrlimit(RLIMIT_NOFILE, &limit);
}

/// What belongs to this program: beside it in a build, in its folder of the system when installed.
fs::path companion(const fs::path& name, const fs::path& installed) {
  const fs::path programs = fs::read_symlink("/proc/self/exe").parent_path();
  const fs::path beside = programs / name;
  return fs::exists(beside) ? beside : (programs / installed / name).lexically_normal();
}

void measure(const Options& options, const std::vector<std::string>& command) {
  const WorkFolder folder;
  Means means{options.mbgated.empty() ? companion("mbgated", MBGATE_DAEMONS_FROM_PROGRAMS)
                                      : fs::absolute(options.mbgated),
              folder.path(), parse_commands(options.commands), std::nullopt,
              companion("mbgate-signer", MBGATE_DAEMONS_FROM_PROGRAMS)};
  if (options.allocations) {
    means.allocations = companion("libmbgate-count-allocations.so", MBGATE_LIBRARIES_FROM_PROGRAMS);
  }
  std::vector<Contest> contests;
  contests.reserve(options.contestants.size());
  for (const std::string& text : options.contestants) {
    contests.push_back({parse_contestant(text, options.common, means.commands), {}});
  }
  if (std::ranges::any_of(
          contests, [](const Contest& contest) { return contest.scenario.load.speaks_tls(); })) {
    make_certificates(companion("mbgate-cert", "."), means.folder);
  }
  const Times times{to_duration(options.warm_up), to_duration(options.seconds)};
  for (unsigned pair = 0; pair < options.pairs; ++pair) {
    for (Contest& contest : contests) {
      contest.runs.push_back(run_once(contest.scenario, means, times));
    }
  }
  print_table(std::cout, contests);
  if (!options.json.empty()) {
    std::ofstream file(options.json);
    file << to_json(contests, command) << "\n" << std::flush;
    if (!file) {
      throw std::runtime_error(options.json.string() + " cannot be written");
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Measures how much of a line a Modbus gateway uses, and how long its answers take: see "
      "bench/README.md",
      "mbgate-bench");
  Options options;
  declare(app, options);
  CLI11_PARSE(app, argc, argv);
  try {
    want_many_files();
    measure(options, {argv, argv + argc});
    return EXIT_SUCCESS;
  } catch (const std::exception& error) {
    std::cerr << "mbgate-bench: " << error.what() << "\n";
    return EXIT_FAILURE;
  }
}
