// SPDX-License-Identifier: Apache-2.0
#include "app/command_line.hpp"

#include <sysexits.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <fmt/core.h>
#include <iostream>

#include "base/text.hpp"
#include "config/keys/keys.hpp"

namespace mbgate::app {
namespace {

/// The options that are given instead of a configuration file.
struct SerialWords {
  SerialOptions options;
  /// Before it is understood. Port 502 would need a privilege.
  std::string listen = "127.0.0.1:1502";
};

/// Returns --serial, without which the others mean nothing.
const CLI::Option* add_serial(CLI::App& app, SerialWords& words, bool& print) {
  constexpr auto kGroup = "Without a configuration file";
  CLI::Option* const serial =
      app.add_option("--serial", words.options.device,
                     "Serve this serial port: units 1 to 247 are the addresses on its line");
  serial->type_name("PATH")->group(kGroup);
  const auto add = [&](const char* name, auto& value, const char* type, const char* description) {
    CLI::Option* const option = app.add_option(name, value, description);
    option->type_name(type)->group(kGroup)->needs(serial);
    return option;
  };
  add("--baud", words.options.baud, "RATE", "As the devices are set")->capture_default_str();
  add("--parity", words.options.parity, "even|odd|none", "As the devices are set")
      ->capture_default_str();
  add("--stop-bits", words.options.stop_bits, "1|2", "As the devices are set")
      ->capture_default_str();
  add("--listen", words.listen, "ADDRESS:PORT",
      "Where clients connect; an IPv6 address in brackets; beyond loopback only with --allow")
      ->capture_default_str();
  add("--allow", words.options.allow, "NETWORK",
      "Who may connect: an address, or a block such as 192.168.10.0/24; can be repeated");
  app.add_flag("--print-config", print, "Print this as a configuration to go on with, then exit")
      ->group(kGroup)
      ->needs(serial);
  return serial;
}

/// Returns --who, without which the others mean nothing.
const CLI::Option* add_who(CLI::App& app, WhoOptions& who, CLI::Option* check) {
  constexpr auto kGroup = "Who may do what (with --check)";
  CLI::Option* const asked =
      app.add_option("--who", who.client,
                     "Say whether this client's request would be permitted, and what decides it");
  asked->type_name("ADDRESS")->group(kGroup)->needs(check);
  const auto add = [&](const char* name, auto& value, const char* type, const char* description) {
    CLI::Option* const option = app.add_option(name, value, description);
    option->type_name(type)->group(kGroup)->needs(asked);
    return option;
  };
  add("--listener", who.listener, "NAME", "Only on this listener");
  add("--role", who.role, "ROLE", "The role in its certificate, \"\" if there is none");
  add("--certificate", who.certificate, "NAME", "The name in its certificate");
  asked->needs(add("--unit", who.unit, "N", "Unit identifier of the request"));
  add("--read", who.read, "TABLE ADDRESS", "The request reads coils, discrete, input or holding")
      ->expected(2);
  add("--write", who.write, "TABLE ADDRESS", "The request writes coils or holding")->expected(2);
  add("--count", who.count, "N", "How many registers or coils")->capture_default_str();
  add("--value", who.value, "N", "The value that it writes, which tells a stop from other writes")
      ->capture_default_str();
  return asked;
}

/// Puts the configuration into `options`, or throws what is wrong.
void take_serial(SerialWords& words, Options& options) {
  const auto listen = parse_listen(words.listen, words.options.allow);
  if (!listen) {
    throw CLI::ValidationError("--listen", listen.error());
  }
  words.options.listen = *listen;
  options.config = "--serial";
  options.text = serial_config(words.options);
}

/// A basic string of TOML 1.0.0. A path can hold any byte but 0; what is no UTF-8 is refused when
/// the text is loaded.
std::string toml_string(std::string_view text) {
  std::string quoted = "\"";
  for (const char byte : text) {
    const auto code = static_cast<unsigned char>(byte);
    if (byte == '"' || byte == '\\') {
      (quoted += '\\') += byte;
    } else if (code < 0x20U || code == 0x7FU) {
      quoted += fmt::format("\\u{:04X}", code);
    } else {
      quoted += byte;
    }
  }
  return quoted + '"';
}

std::string allow_line(const std::vector<std::string>& allow) {
  return allow.empty() ? "" : fmt::format("allow = [{}]\n", joined(allow, toml_string));
}

}  // namespace

std::variant<Options, int> parse_command_line(int argc, const char* const* argv,
                                              const std::string& version) {
  Options options;
  CLI::App app("mbgated: Modbus TCP gateway to devices on serial lines and to Modbus TCP servers",
               "mbgated");
  const CLI::Option* const config =
      app.add_option("--config", options.config,
                     "The configuration file; those of conf.d beside it are read too")
          ->type_name("FILE")
          ->capture_default_str();
  app.add_option("--profiles", options.profiles,
                 "Look for drive profiles in this folder only (instead of [gateway] profiles, or "
                 "/etc/mbgate/profiles and the installed ones)")
      ->type_name("DIR")
      ->check(CLI::ExistingDirectory);
  app.add_option("--record", options.record,
                 "Write a recording of all clients and lines to this file, in the service's state "
                 "directory if it has one; it grows as long as mbgated runs")
      ->type_name("FILE");
  CLI::Option* const check = app.add_flag(
      "--check", options.check, "Validate the configuration without touching a port, then exit");
  bool keys = false;
  app.add_flag(
      "--keys", keys,
      "Print what each key with a single value takes: section, key, range, default and where "
      "it belongs, separated by tabs; then exit");
  app.set_version_flag("--version", "mbgated " + version);
  SerialWords words;
  const CLI::Option* const serial = add_serial(app, words, options.print);
  WhoOptions who;
  const CLI::Option* const asked = add_who(app, who, check);
  try {
    app.parse(argc, argv);
    if (serial->count() > 0 && config->count() > 0) {
      throw CLI::ValidationError("--serial",
                                 "takes the place of a configuration file: leave out --config");
    }
    if (serial->count() > 0) {
      take_serial(words, options);
    }
    if (asked->count() > 0) {
      options.who = who;
    }
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == EXIT_SUCCESS ? EXIT_SUCCESS : EX_USAGE;
  }
  if (keys) {
    std::cout << config::list_keys();
    return EXIT_SUCCESS;
  }
  return options;
}

Result<ListenAddress, std::string> parse_listen(std::string_view text,
                                                const std::vector<std::string>& allow) {
  const auto listen = ListenAddress::parse(text);
  if (!listen) {
    return fmt::format(
        "expected an IPv4 or IPv6 address and a port, such as 127.0.0.1:1502 or [::1]:1502, found "
        "\"{}\"",
        text);
  }
  if (allow.empty() && !routing::is_loopback(listen->address)) {
    return fmt::format(
        "other machines can reach {}: add --allow with the permitted clients, such as --allow "
        "192.168.10.0/24",
        listen->address.to_text());
  }
  return *listen;
}

std::string serial_config(const SerialOptions& options) {
  return fmt::format(R"(# What mbgated --serial serves. mbgate.toml(5) has every key.

[[listen]]
name = "clients"
address = {}
port = {}
bus = "line"
{}
[[bus]]
name = "line"
device = {}
baud = {}
parity = {}
stop_bits = {}
)",
                     toml_string(options.listen.address.to_text()), options.listen.port,
                     allow_line(options.allow), toml_string(options.device), options.baud,
                     toml_string(options.parity), options.stop_bits);
}

}  // namespace mbgate::app
