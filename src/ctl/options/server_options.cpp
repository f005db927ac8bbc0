// SPDX-License-Identifier: Apache-2.0
#include "ctl/options/server_options.hpp"

#include <CLI/CLI.hpp>

#include "config/toml/duration_text.hpp"

namespace mbgate::ctl {
namespace {

constexpr std::uint16_t kTlsPort = 802;  // registered for Modbus/TCP Security

}  // namespace

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
  command.add_option("--port", port_, "TCP port")
      ->check(CLI::Range(1, 65535))
      ->default_str(std::to_string(target_.port));
  command.add_option("--timeout", timeout_, "for the connection and for the answer")
      ->capture_default_str();
}

void ServerOptions::add_tls_to(CLI::App& command) {
  auto* tls =
      command.add_flag("--tls", tls_, "over TLS (Modbus/TCP Security), port 802 by default");
  command.add_option("--certificate", identity_.certificate, "with --tls: our certificate, in PEM")
      ->needs(tls);
  command.add_option("--key", identity_.key, "with --tls: its private key, in PEM")->needs(tls);
  command
      .add_option("--authorities", identity_.authorities,
                  "with --tls: who may have signed the gateway's certificate, in PEM")
      ->needs(tls);
  command
      .add_option("--server-name", identity_.server_name,
                  "with --tls: the name or address in the gateway's certificate; default: --host")
      ->needs(tls);
}

Result<Target, std::string> ServerOptions::target() const {
  const auto timeout = parse_time(timeout_, std::chrono::milliseconds(1));
  if (!timeout) {
    // Said in full, because a text alone could be a target too, its host.
    return {boost::system::in_place_error, timeout.error()};
  }
  Target target = target_;
  target.timeout = *timeout;
  if (tls_) {
    if (identity_.certificate.empty() || identity_.key.empty() || identity_.authorities.empty()) {
      return {boost::system::in_place_error,
              "--tls needs --certificate, --key and --authorities: the server is to know who asks, "
              "and so are we who answers (mbgate-cert makes such files)"};
    }
    target.tls = identity_;
    target.port = kTlsPort;
  }
  target.port = port_.value_or(target.port);
  return target;
}

}  // namespace mbgate::ctl
