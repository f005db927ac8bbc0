// SPDX-License-Identifier: Apache-2.0
#include "ctl/options/scan_options.hpp"

#include <CLI/CLI.hpp>

#include "ctl/options/profile_options.hpp"
#include "ctl/scan/scan.hpp"

namespace mbgate::ctl {
namespace {

/// What a configuration takes for a name.
bool is_bus_name(const std::string& name) {
  constexpr std::size_t kLongest = 64;
  return !name.empty() && name.size() <= kLongest &&
         name.find_first_not_of(
             "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
             "-_.") == std::string::npos;
}

}  // namespace

ScanOptions::ScanOptions(CLI::App& app)
    : scan_(app.add_subcommand(
          "scan",
          "Ask every unit of a bus what it is, through a transparent listener, and print a "
          "configuration to start from. Only reads (functions 01 to 04) are sent, one at a time. "
          "Each unit that is absent costs the bus's response timeout, once more for each retry: "
          "about 2 s with the defaults, a minute for 32 units. With --device a serial port is "
          "scanned without a gateway, and its rate and parity are found out.")) {
  scan_->add_option("--units", units_, "whom to ask: 5 or 1-32 or 1-8,17")->capture_default_str();
  server_.add_to(*scan_);
  port_.add_to(*scan_);
  add_profile_folder(*scan_, words_.folder);
  scan_->add_option("--bus", words_.bus, "its name in the configuration")
      ->check([](const std::string& name) {
        return is_bus_name(name) ? std::string() : "expected 1 to 64 letters, digits, - _ .";
      })
      ->capture_default_str();
  scan_->add_option("--config", words_.config, "write the configuration to this new file")
      ->type_name("FILE");
  scan_->add_flag("--json", words_.json, "for programs: one JSON object");
}

bool ScanOptions::given() const { return scan_->parsed(); }

Result<Command, std::string> ScanOptions::command() const {
  const auto target = server_.target();
  if (!target) {
    return target.error();
  }
  auto units = parse_units(units_);
  if (!units) {
    return units.error();
  }
  ScanCommand scan = words_;
  scan.target = *target;
  scan.units = *std::move(units);
  if (port_.given()) {
    auto port = port_.port();
    if (!port) {
      return port.error();
    }
    scan.port = *std::move(port);
  }
  return Command(scan);
}

}  // namespace mbgate::ctl
