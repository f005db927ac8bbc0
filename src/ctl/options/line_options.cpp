// SPDX-License-Identifier: Apache-2.0
// Subcommands that find out what is on a line.
#include <CLI/CLI.hpp>
#include <memory>

#include "ctl/options/subcommands.hpp"
#include "ctl/scan/scan.hpp"

namespace mbgate::ctl {
namespace {

constexpr unsigned kMostReads = 10'000;
constexpr std::chrono::milliseconds kShortestTime{1};

/// A serial port without a gateway, and its modes.
struct PortWords {
  std::string device;
  std::string bauds;
  std::string parities;
  std::string stop_bits = "1";
  std::string wait;
};

struct ScanWords {
  ScanCommand command;
  ServerWords server;
  // 9600 first: the most frequent setting of drives as they are delivered.
  PortWords port{{}, "9600,19200,115200,38400,57600", "even,none,odd", "1", "100ms"};
  bool all_modes = false;
  std::string units = "1-32";
};

struct DoctorWords {
  DoctorCommand command;
  PortWords port{{}, "19200", "even", "1", "1s"};
  std::string units;
  std::string listen = "2s";
};

CLI::Option* add_device(CLI::App& command, PortWords& words, const std::string& what) {
  return command.add_option("--device", words.device, what)
      ->type_name("PATH")
      ->check([](const std::string& path) {
        return path.empty() ? "expected the path of a serial port" : std::string();
      });
}

/// An option that goes with --device.
void add_with(CLI::App& command, CLI::Option* device, const std::string& name, std::string& word,
              const std::string& what) {
  command.add_option(name, word, "with --device: " + what)->needs(device);
}

/// What a configuration takes for a name.
std::string wrong_bus_name(const std::string& name) {
  constexpr std::size_t kLongest = 64;
  const bool is_name = !name.empty() && name.size() <= kLongest &&
                       name.find_first_not_of(
                           "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
                           "-_.") == std::string::npos;
  return is_name ? std::string() : "expected 1 to 64 letters, digits, - _ .";
}

void add_port_to_scan(CLI::App& scan, ScanWords& words) {
  PortWords& port = words.port;
  auto* device =
      add_device(scan, port, "scan this serial port, which no gateway may hold: /dev/ttyUSB0");
  for (const auto* other : {"--host", "--port", "--timeout"}) {
    device->excludes(scan.get_option(other));
  }
  add_with(scan, device, "--bauds", port.bauds, "the rates to try, in this order");
  add_with(scan, device, "--parities", port.parities, "even, none, odd, in this order");
  add_with(scan, device, "--stop-bits", port.stop_bits,
           "1, 2 or 1,2 where there is no parity; else it is always 1");
  add_with(scan, device, "--wait", port.wait,
           "for the first byte of an answer; some drives need 1s");
  scan.add_flag("--all-modes", words.all_modes,
                "with --device: try every rate and parity, not only until one has an answer")
      ->needs(device);
}

ScanCommand scan_of(const ScanWords& words) {
  ScanCommand scan = words.command;
  scan.target = target_of(words.server);
  scan.units = expect(parse_units(words.units));
  const PortWords& port = words.port;
  if (!port.device.empty()) {
    auto modes = expect(parse_modes(port.bauds, port.parities, port.stop_bits));
    scan.port = PortSweep{port.device, std::move(modes), parse_time(port.wait, kShortestTime),
                          words.all_modes};
  }
  return scan;
}

void add_line_to_doctor(CLI::App& doctor, DoctorWords& words) {
  PortWords& port = words.port;
  auto* device =
      add_device(doctor, port, "examine this serial port, which no configuration describes");
  add_with(doctor, device, "--baud", port.bauds, "its rate");
  add_with(doctor, device, "--parity", port.parities, "even, none or odd");
  add_with(doctor, device, "--stop-bits", port.stop_bits, "1, or 2 where there is no parity");
  add_with(doctor, device, "--timeout", port.wait,
           "response timeout: an answer that begins later counts as late");
  doctor
      .add_option("--bus", words.command.bus,
                  "examine this bus; required if the configuration has several")
      ->type_name("NAME")
      ->excludes(device);
  doctor.add_option("--config", words.command.config, "the configuration file, with --bus")
      ->excludes(device);
  add_profile_folder(doctor, words.command.folder);
}

DoctorCommand doctor_of(const DoctorWords& words) {
  DoctorCommand doctor = words.command;
  const PortWords& port = words.port;
  if (!port.device.empty()) {
    const auto modes = expect(parse_modes(port.bauds, port.parities, port.stop_bits));
    if (modes.size() != 1) {
      throw WrongUsage("one rate, one parity, and 1 or 2 stop bits: no lists");
    }
    doctor.port = ExaminedPort{port.device, modes.front(), parse_time(port.wait, kShortestTime)};
  }
  if (!words.units.empty()) {
    doctor.units = expect(parse_units(words.units));
  }
  doctor.listen = parse_time(words.listen, kShortestTime);
  return doctor;
}

}  // namespace

void add_scan(CLI::App& app, const Choose& choose) {
  auto* scan = app.add_subcommand(
      "scan",
      "Identify the device at every unit of a bus, through a transparent listener, and print a "
      "configuration to start from. Only reads (functions 01 to 04) are sent, one at a time. "
      "Each unit that is absent takes a little longer than the bus's response timeout, 1 s by "
      "default. A unit that the gateway takes for offline gets only short probes, and may be "
      "missed: scan again when its drive has been on for some seconds. With --device a serial port "
      "is scanned without a gateway, and its baud rate and parity are found.");
  const auto words = std::make_shared<ScanWords>();
  ScanCommand& command = words->command;
  scan->add_option("--units", words->units, "units to ask: 5 or 1-32 or 1-8,17");
  add_server(*scan, words->server);
  add_port_to_scan(*scan, *words);
  add_profile_folder(*scan, command.folder);
  scan->add_option("--bus", command.bus, "its name in the configuration")->check(wrong_bus_name);
  scan->add_option("--config", command.config, "write the configuration to this new file")
      ->type_name("FILE");
  scan->add_flag("--json", command.json, "for programs: one JSON object");
  scan->callback([words, choose] { choose(scan_of(*words)); });
}

void add_doctor(CLI::App& app, const Choose& choose) {
  auto* doctor = app.add_subcommand(
      "doctor",
      "Examine a serial line step by step and report each fault with its evidence: the port, its "
      "permissions, the process that holds it, the adapter's delay, noise, echo, the answers of "
      "the devices, two devices at one address. No gateway may hold the port. Only reads are "
      "sent, and none once another client is heard.");
  const auto words = std::make_shared<DoctorWords>();
  DoctorCommand& command = words->command;
  add_line_to_doctor(*doctor, *words);
  doctor->add_option("--address", words->units,
                     "addresses to ask: 5 or 1-8,17; default: the devices of the configuration");
  doctor->add_option("--register", command.holding_register,
                     "protocol address of the holding register to read");
  doctor->add_option("--requests", command.requests, "how many reads each device gets")
      ->check(CLI::Range(1U, kMostReads));
  doctor->add_option("--listen", words->listen, "how long to listen before anything is sent");
  doctor->add_flag("--json", command.json, "for programs: one JSON object");
  doctor->callback([words, choose] { choose(doctor_of(*words)); });
}

}  // namespace mbgate::ctl
