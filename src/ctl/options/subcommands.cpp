// SPDX-License-Identifier: Apache-2.0
#include "ctl/options/subcommands.hpp"

#include <CLI/CLI.hpp>
#include <fmt/core.h>
#include <memory>
#include <sstream>

#include "config/toml/toml_value.hpp"
#include "ctl/control/connection_shell.hpp"
#include "ctl/request/carry_out.hpp"
#include "ctl/visible_text.hpp"

namespace mbgate::ctl {
namespace {

constexpr std::uint16_t kTlsPort = 802;  // registered for Modbus/TCP Security

}  // namespace

std::chrono::nanoseconds parse_time(const std::string& text, std::chrono::milliseconds least) {
  const auto time = config::parse_duration(text);
  if (!time || *time < least) {
    throw WrongUsage(fmt::format("\"{}\" is not a time from {} to 1000h, like 500ms or 5s", text,
                                 config::to_text(least)));
  }
  return *time;
}

void add_server(CLI::App& command, ServerWords& words) {
  command.add_option("--host", words.target.host, "name or address of the gateway");
  command.add_option("--port", words.port, "TCP port")
      ->check(CLI::Range(1, 65535))
      ->default_str(std::to_string(words.target.port));
  command.add_option("--timeout", words.timeout, "for the connection and for the answer");
}

void add_tls(CLI::App& command, ServerWords& words) {
  auto* tls =
      command.add_flag("--tls", words.tls, "over TLS (Modbus/TCP Security), port 802 by default");
  const auto add = [&](const std::string& name, auto& word, const std::string& what) {
    command.add_option(name, word, "with --tls: " + what)->needs(tls)->default_str("");
  };
  TlsIdentity& identity = words.identity;
  add("--certificate", identity.certificate, "our certificate, in PEM");
  add("--key", identity.key, "its private key, in PEM");
  add("--authorities", identity.authorities,
      "authorities that may have signed the gateway's certificate, in PEM");
  add("--server-name", identity.server_name,
      "the name or address in the gateway's certificate; default: --host");
}

void add_profile_folder(CLI::App& command, std::optional<std::filesystem::path>& folder) {
  command
      .add_option("--profiles", folder,
                  "look in this folder only, instead of /etc/mbgate/profiles and the installed "
                  "ones")
      ->type_name("DIR")
      ->check(CLI::ExistingDirectory);
}

void add_control(CLI::App& command, std::string& socket, bool only_reads) {
  command
      .add_option("--control", socket,
                  only_reads ? "the control socket, or tcp://HOST:PORT, an address in listen of "
                               "[http]"
                             : "the control socket")
      ->type_name("PLACE")
      ->check(&wrong_place);
}

Target target_of(const ServerWords& words) {
  Target target = words.target;
  target.timeout = parse_time(words.timeout, std::chrono::milliseconds(1));
  if (words.tls) {
    const TlsIdentity& identity = words.identity;
    if (identity.certificate.empty() || identity.key.empty() || identity.authorities.empty()) {
      throw WrongUsage(
          "--tls needs --certificate, --key and --authorities: client and server identify each "
          "other (mbgate-cert makes such files)");
    }
    target.tls = identity;
    target.port = kTlsPort;
  }
  target.port = words.port.value_or(target.port);
  return target;
}

void add_profile(CLI::App& app, const Choose& choose) {
  auto* profile = app.add_subcommand("profile", "Show a drive profile, or list all of them.");
  const auto words = std::make_shared<ProfileCommand>();
  profile->add_option("name", words->which, "name or file of a profile; default: list all");
  add_profile_folder(*profile, words->folder);
  profile->add_flag("--json", words->json, "for programs");
  profile->callback([words, choose] { choose(*words); });
}

void add_check(CLI::App& app, const Choose& choose) {
  auto* check = app.add_subcommand(
      "check", "Report the errors of a configuration, as mbgated --check does. No port is opened.");
  const auto words = std::make_shared<CheckCommand>();
  check->add_option("file", words->config,
                    "the configuration file; those of conf.d beside it are read too");
  add_profile_folder(*check, words->folder);
  check->callback([words, choose] { choose(*words); });
}

void add_replay(CLI::App& app, const Choose& choose) {
  auto* replay = app.add_subcommand(
      "replay",
      "Replay a recording of mbgated, and report where this version first does something else. No "
      "port is opened.");
  const auto words = std::make_shared<ReplayCommand>();
  replay->add_option("file", words->recording, "a recording of mbgated --record")
      ->required()
      ->default_str("");
  add_profile_folder(*replay, words->folder);
  replay->callback([words, choose] { choose(*words); });
}

std::variant<Command, Notice> parse_command_line(const std::string& version, int count,
                                                 const char* const* arguments) {
  CLI::App app(
      "Reads and writes Modbus devices through mbgated or any other Modbus TCP server, shows the "
      "status of a running mbgated, scans and examines serial lines, shows drive profiles, checks "
      "configurations, and replays recordings.",
      "mbgatectl");
  app.set_version_flag("--version", "mbgatectl " + version);
  app.require_subcommand(1);
  app.option_defaults()->always_capture_default();
  app.get_formatter()->column_width(22);
  std::optional<Command> chosen;
  for (const auto add :
       {add_read, add_write, add_profile, add_scan, add_check, add_replay, add_doctor, add_status,
        add_reload, add_clear_counters, add_events, add_trace}) {
    add(app, [&chosen](const Command& command) { chosen = command; });
  }
  try {
    app.parse(count, arguments);
  } catch (const WrongUsage& error) {
    return Notice{kExitUsage, fmt::format("mbgatectl: {}\n", error.what())};
  } catch (const CLI::ParseError& error) {
    const auto words = app.remaining();
    if (app.get_subcommands().empty() && !words.empty() && !words.front().starts_with('-')) {
      return Notice{kExitUsage, fmt::format("mbgatectl: there is no subcommand {}\n",
                                            visible_text(words.front()))};
    }
    std::ostringstream text;
    const int status = app.exit(error, text, text);
    return Notice{status == 0 ? kExitDone : kExitUsage,
                  status == 0 ? text.str() : "mbgatectl: " + text.str()};
  }
  return *std::move(chosen);
}

}  // namespace mbgate::ctl
