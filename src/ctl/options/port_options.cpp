// SPDX-License-Identifier: Apache-2.0
#include "ctl/options/port_options.hpp"

#include <CLI/CLI.hpp>

#include "ctl/options/server_options.hpp"

namespace mbgate::ctl {

void PortOptions::add_to(CLI::App& command) {
  auto* device = command
                     .add_option("--device", device_,
                                 "scan this serial port, which no gateway may hold: /dev/ttyUSB0")
                     ->type_name("PATH")
                     ->check([](const std::string& path) {
                       return path.empty() ? "expected the path of a serial port" : std::string();
                     });
  for (const auto* other : {"--host", "--port", "--timeout"}) {
    device->excludes(command.get_option(other));
  }
  command.add_option("--bauds", bauds_, "with --device: the rates to try, in this order")
      ->needs(device)
      ->capture_default_str();
  command.add_option("--parities", parities_, "with --device: even, none, odd, in this order")
      ->needs(device)
      ->capture_default_str();
  command
      .add_option("--stop-bits", stop_bits_,
                  "with --device: 1, 2 or 1,2 where there is no parity; else it is always 1")
      ->needs(device)
      ->capture_default_str();
  command
      .add_option("--wait", wait_,
                  "with --device: for the first byte of an answer; some drives need 1s")
      ->needs(device)
      ->capture_default_str();
  command
      .add_flag("--all-modes", all_modes_,
                "with --device: try every rate and parity, not only until one has an answer")
      ->needs(device);
}

Result<PortSweep, std::string> PortOptions::port() const {
  auto modes = parse_modes(bauds_, parities_, stop_bits_);
  if (!modes) {
    // Said in full, because a text alone could be a port too, its path.
    return {boost::system::in_place_error, modes.error()};
  }
  const auto wait = parse_time(wait_, std::chrono::milliseconds(1));
  if (!wait) {
    return {boost::system::in_place_error, wait.error()};
  }
  return PortSweep{device_, *std::move(modes), *wait, all_modes_};
}

}  // namespace mbgate::ctl
