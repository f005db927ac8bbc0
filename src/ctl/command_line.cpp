// SPDX-License-Identifier: Apache-2.0
#include "ctl/command_line.hpp"

#include <CLI/CLI.hpp>
#include <map>
#include <sstream>

#include "config/toml/duration_text.hpp"
#include "ctl/request/carry_out.hpp"
#include "ctl/scan/scan.hpp"

namespace mbgate::ctl {
namespace {

const std::map<std::string, Table> kTables{{"coils", Table::coils},
                                           {"discrete", Table::discrete_inputs},
                                           {"holding", Table::holding_registers},
                                           {"input", Table::input_registers}};
const std::map<std::string, ValueType> kTypes{{"u16", ValueType::u16},
                                              {"i16", ValueType::i16},
                                              {"u32", ValueType::u32},
                                              {"i32", ValueType::i32},
                                              {"f32", ValueType::f32}};
const std::map<std::string, drive::WordOrder> kOrders{{"big", drive::WordOrder::big},
                                                      {"little", drive::WordOrder::little}};

/// What the user wrote, before it is understood.
struct Words {
  std::string table = "holding";
  std::string address;
  std::string type;
  std::string order = "big";
  std::string timeout = "5s";
  std::vector<std::string> values;
  unsigned unit = 1;
  Target target;
  std::size_t count = 1;
  bool multiple = false;
  bool quiet = false;
  std::string units = "1-32";
  ProfileCommand profile;
  ScanCommand scan;
  StatusCommand status;
  ReloadCommand reload;
};

/// What a configuration takes for a name.
bool is_bus_name(const std::string& name) {
  constexpr std::size_t kLongest = 64;
  return !name.empty() && name.size() <= kLongest &&
         name.find_first_not_of(
             "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
             "-_.") == std::string::npos;
}

template <typename Value>
CLI::IsMember one_of(const std::map<std::string, Value>& names) {
  std::vector<std::string> keys;
  keys.reserve(names.size());
  for (const auto& [name, value] : names) {
    keys.push_back(name);
  }
  return CLI::IsMember(keys);
}

void add_server(CLI::App& command, Words& words) {
  command.add_option("--host", words.target.host, "name or address of the gateway")
      ->capture_default_str();
  command.add_option("--port", words.target.port, "TCP port")
      ->check(CLI::Range(1, 65535))
      ->capture_default_str();
  command.add_option("--timeout", words.timeout, "for the connection and for the answer")
      ->capture_default_str();
}

void add_profiles(CLI::App& command, std::optional<std::filesystem::path>& folder) {
  command
      .add_option("--profiles", folder,
                  "look in this folder only, instead of /etc/mbgate/profiles and the installed "
                  "ones")
      ->type_name("DIR")
      ->check(CLI::ExistingDirectory);
}

void add_common(CLI::App& command, Words& words) {
  command.add_option("address", words.address, "protocol address, counted from 0: 30 or 0x1E")
      ->required();
  command.add_option("--type", words.type, "of registers: u16 (default), i16, u32, i32 or f32")
      ->check(one_of(kTypes));
  command
      .add_option("--order", words.order,
                  "of the two registers of a 32-bit value: big (high word first) or little")
      ->check(one_of(kOrders))
      ->capture_default_str();
  command.add_option("--unit", words.unit, "unit identifier")
      ->check(CLI::Range(0, 255))
      ->capture_default_str();
  add_server(command, words);
}

CLI::App* add_read(CLI::App& app, Words& words) {
  CLI::App* read = app.add_subcommand("read", "Read coils, discrete inputs or registers.");
  read->add_option("table", words.table, "coils, discrete, holding or input")
      ->required()
      ->check(one_of(kTables));
  add_common(*read, words);
  read->add_option("--count", words.count, "how many values")->capture_default_str();
  read->add_flag("--quiet", words.quiet, "print the plain values only, one a line");
  return read;
}

CLI::App* add_write(CLI::App& app, Words& words) {
  CLI::App* write = app.add_subcommand("write", "Write coils or holding registers.");
  write->add_option("table", words.table, "coils or holding")
      ->required()
      ->check(CLI::IsMember(std::vector<std::string>{"coils", "holding"}));
  add_common(*write, words);
  write
      ->add_option(
          "values", words.values,
          "decimal, or hex as the bits that go out (0xFFFE is -2 as i16); coils: 0, 1, off or on")
      ->required();
  write->add_flag("--multiple", words.multiple,
                  "use functions 15 and 16 even for one coil or register");
  write->add_flag("--quiet", words.quiet, "print nothing on success");
  return write;
}

CLI::App* add_profile(CLI::App& app, Words& words) {
  CLI::App* profile =
      app.add_subcommand("profile", "Show what is known of a kind of drive, or list all kinds.");
  profile->add_option("name", words.profile.which, "of a profile, or a file; none: list all");
  add_profiles(*profile, words.profile.folder);
  profile->add_flag("--json", words.profile.json, "for programs");
  return profile;
}

CLI::App* add_scan(CLI::App& app, Words& words) {
  CLI::App* scan = app.add_subcommand(
      "scan",
      "Ask every unit of a bus what it is, through a transparent listener, and print a "
      "configuration to start from. Only reads (functions 01 to 04) are sent, one at a time. "
      "Each unit that is absent costs the bus's response timeout, once more for each retry: "
      "about 2 s with the defaults, a minute for 32 units.");
  scan->add_option("--units", words.units, "whom to ask: 5 or 1-32 or 1-8,17")
      ->capture_default_str();
  add_server(*scan, words);
  add_profiles(*scan, words.scan.folder);
  scan->add_option("--bus", words.scan.bus, "its name in the configuration")
      ->check([](const std::string& name) {
        return is_bus_name(name) ? std::string() : "expected 1 to 64 letters, digits, - _ .";
      })
      ->capture_default_str();
  scan->add_option("--config", words.scan.config, "write the configuration to this new file")
      ->type_name("FILE");
  return scan;
}

void add_control(CLI::App& command, std::string& socket) {
  command.add_option("--control", socket, "the control socket of mbgated, its [http] socket")
      ->type_name("PATH")
      ->capture_default_str();
}

CLI::App* add_status(CLI::App& app, Words& words) {
  CLI::App* status = app.add_subcommand(
      "status",
      "Show how a running mbgated, its lines and its drives are: what is not well first.");
  status->add_flag("--json", words.status.json, "for programs");
  add_control(*status, words.status.socket);
  return status;
}

CLI::App* add_reload(CLI::App& app, Words& words) {
  CLI::App* reload = app.add_subcommand(
      "reload",
      "Have a running mbgated read its configuration again, and say what has changed or why it was "
      "refused.");
  add_control(*reload, words.reload.socket);
  return reload;
}

Result<Place, std::string> understand_place(const Words& words) {
  Place place;
  place.table = kTables.at(words.table);
  place.order = kOrders.at(words.order);
  const bool bits = place.table == Table::coils || place.table == Table::discrete_inputs;
  if (bits && !words.type.empty()) {
    return "--type is for registers: " + words.table + " hold bits";
  }
  if (bits) {
    place.type = ValueType::bit;
  } else if (!words.type.empty()) {
    place.type = kTypes.at(words.type);
  }
  const auto address = parse_address(words.address);
  if (!address) {
    return address.error();
  }
  place.address = *address;
  return place;
}

Result<std::chrono::nanoseconds, std::string> understand_timeout(const Words& words) {
  const auto timeout = config::parse_duration(words.timeout);
  if (!timeout || *timeout < std::chrono::milliseconds(1)) {
    return "\"" + words.timeout + "\" is not a time of at least 1ms, like 500ms or 5s";
  }
  return *timeout;
}

Result<Command, std::string> understand_scan(const Words& words) {
  const auto timeout = understand_timeout(words);
  if (!timeout) {
    return timeout.error();
  }
  auto units = parse_units(words.units);
  if (!units) {
    return units.error();
  }
  ScanCommand scan = words.scan;
  scan.target = words.target;
  scan.target.timeout = *timeout;
  scan.units = *std::move(units);
  return Command(scan);
}

Result<Command, std::string> understand(const Words& words, bool is_write) {
  const auto timeout = understand_timeout(words);
  if (!timeout) {
    return timeout.error();
  }
  Target target = words.target;
  target.timeout = *timeout;
  target.unit = static_cast<std::uint8_t>(words.unit);
  const auto place = understand_place(words);
  if (!place) {
    return place.error();
  }
  if (!is_write) {
    return Command(ReadCommand{target, *place, words.count, words.quiet});
  }
  WriteCommand write{target, *place, {}, words.multiple, words.quiet};
  for (const auto& text : words.values) {
    const auto value = parse_value(place->type, text);
    if (!value) {
      return value.error();
    }
    write.values.push_back(*value);
  }
  return Command(write);
}

}  // namespace

std::variant<Command, Notice> parse_command_line(const std::string& version, int count,
                                                 const char* const* arguments) {
  CLI::App app(
      "Reads and writes Modbus devices through a gateway, or any Modbus TCP server, finds out what "
      "is on a bus, shows drive profiles, and asks a running mbgated how it is.",
      "mbgatectl");
  app.set_version_flag("--version", "mbgatectl " + version);
  app.require_subcommand(1);
  app.get_formatter()->column_width(22);
  Words words;
  add_read(app, words);
  const CLI::App* write = add_write(app, words);
  const CLI::App* profile = add_profile(app, words);
  const CLI::App* scan = add_scan(app, words);
  const CLI::App* asks_status = add_status(app, words);
  const CLI::App* asks_reload = add_reload(app, words);
  try {
    app.parse(count, arguments);
  } catch (const CLI::ParseError& error) {
    std::ostringstream text;
    const int status = app.exit(error, text, text);
    return Notice{status == 0 ? kExitDone : kExitUsage,
                  status == 0 ? text.str() : "mbgatectl: " + text.str()};
  }
  if (profile->parsed()) {
    return words.profile;
  }
  if (asks_status->parsed()) {
    return words.status;
  }
  if (asks_reload->parsed()) {
    return words.reload;
  }
  const auto command = scan->parsed() ? understand_scan(words) : understand(words, write->parsed());
  if (!command) {
    return Notice{kExitUsage, "mbgatectl: " + command.error() + "\n"};
  }
  return *command;
}

}  // namespace mbgate::ctl
