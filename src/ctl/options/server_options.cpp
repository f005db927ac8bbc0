// SPDX-License-Identifier: Apache-2.0
#include "ctl/options/server_options.hpp"

#include <CLI/CLI.hpp>

#include "config/toml/duration_text.hpp"

namespace mbgate::ctl {

Result<std::chrono::nanoseconds, std::string> parse_time(const std::string& text,
                                                         std::chrono::milliseconds least) {
  const auto time = config::parse_duration(text);
  if (!time || *time < least) {
    return "\"" + text + "\" is not a time of at least " + config::to_text(least) +
           ", like 500ms or 5s";
  }
  return *time;
}

void ServerOptions::add_to(CLI::App& command) {
  command.add_option("--host", target_.host, "name or address of the gateway")
      ->capture_default_str();
  command.add_option("--port", target_.port, "TCP port")
      ->check(CLI::Range(1, 65535))
      ->capture_default_str();
  command.add_option("--timeout", timeout_, "for the connection and for the answer")
      ->capture_default_str();
}

Result<Target, std::string> ServerOptions::target() const {
  const auto timeout = parse_time(timeout_, std::chrono::milliseconds(1));
  if (!timeout) {
    // Said in full, because a text alone could be a target too, its host.
    return {boost::system::in_place_error, timeout.error()};
  }
  Target target = target_;
  target.timeout = *timeout;
  return target;
}

}  // namespace mbgate::ctl
