// SPDX-License-Identifier: Apache-2.0
// The line of a bus: a serial port, a serial device server behind TCP, or a Modbus TCP server.
#include <array>
#include <cmath>
#include <fmt/core.h>

#include "base/text.hpp"
#include "config/sections/sections.hpp"

namespace mbgate::config {
namespace {

using bus::Framing;
using modbus::Parity;

constexpr std::array kDirections = {
    Word{"off", bus::Rs485::off}, Word{"kernel", bus::Rs485::kernel}, Word{"rts", bus::Rs485::rts}};

constexpr std::string_view kScheme = "tcp://";

/// Keys of serial lines, and of a Modbus TCP server, that are no plain ones.
constexpr std::initializer_list<const char*> kSerialKeys = {"device", "data_bits", "parity",
                                                            "rs485",  "echo",      "paced"};
constexpr std::initializer_list<const char*> kServerKeys = {"host", "port"};

void read_device(TomlTable& table, bus::LineSettings& line) {
  if (!table.require("device")) {
    return;
  }
  assign(line.device, table.string("device"));
  const std::string_view device = line.device;
  if (device.empty() && std::get_if<std::string>(&table.value("device")->data) != nullptr) {
    table.error("device", "expected the path of a serial port, found an empty string");
  }
  if (device.find("://") == std::string_view::npos) {
    return;
  }
  const auto server =
      device.starts_with(kScheme) ? server_in(device.substr(kScheme.size())) : std::nullopt;
  if (server) {
    line.remote = {server->host, server->port};
  }
  if (!line.remote) {
    table.report_expected("device", *table.value("device"),
                          "the path of a serial port, or \"tcp://host:port\" of a serial device "
                          "server (an IPv6 address in brackets)");
  }
}

void read_character(TomlTable& table, bus::LineSettings& line) {
  const bool ascii = line.framing == Framing::ascii;
  line.format.data_bits = ascii ? 7 : 8;
  const auto data_bits = table.integer("data_bits", {5, 8});
  if (data_bits && ascii && *data_bits < 7) {
    table.error("data_bits", "ASCII characters have 7 or 8 data bits, found {}", *data_bits);
  } else if (data_bits && !ascii && *data_bits != 8) {
    table.error("data_bits", "RTU characters have 8 data bits (Serial Line V1.02, 2.5.1), found {}",
                *data_bits);
  } else {
    assign(line.format.data_bits, data_bits);
  }
  assign(line.format.parity, table.word<Parity>("parity", kParities));
}

/// Direction control by the kernel, where it differs from the device tree.
void read_direction(TomlTable& table, bus::LineSettings& line) {
  assign(line.rs485, table.word<bus::Rs485>("rs485", kDirections));
  if (line.rs485 != bus::Rs485::kernel) {
    table.reject({"rs485_rts_on_send", "rs485_delay_before", "rs485_delay_after"},
                 "belongs to rs485 = \"kernel\"");
  }
}

/// true, false, or "auto": found out.
void read_switch(TomlTable& table, const char* key, std::optional<bool>& target) {
  const TomlValue* value = table.value(key);
  if (value == nullptr) {
    return;
  }
  const auto* text = std::get_if<std::string>(&value->data);
  const auto* chosen = std::get_if<bool>(&value->data);
  if (chosen != nullptr) {
    target = *chosen;
  } else if (text != nullptr && *text == "auto") {
    target.reset();
  } else {
    table.report_expected(key, *value, "true, false or \"auto\"");
  }
}

void read_serial(TomlTable& table, bus::LineSettings& line) {
  read_character(table, line);
  read_direction(table, line);
  read_switch(table, "echo", line.echo);
  read_switch(table, "paced", line.paced);
  if (line.remote && line.rs485 != bus::Rs485::off) {
    table.error("rs485",
                "the serial device server switches the direction itself: expected \"off\"");
  }
  check_habits(table, line);
  table.reject(kServerKeys,
               R"(belongs to mode = "tcp"; a serial device server is device = "tcp://host:port")");
}

void read_server(TomlTable& table, bus::LineSettings& line) {
  bus::Endpoint server;
  if (table.require("host")) {
    assign(server.host, table.string("host"));
    if (server.host.empty() && std::get_if<std::string>(&table.value("host")->data) != nullptr) {
      table.error("host", "expected a name or an address, found an empty string");
    }
  }
  assign(server.port, table.integer("port", {1, 65535}));
  line.remote = std::move(server);
  table.reject(kSerialKeys, "belongs to a serial line; a Modbus TCP server has 'host' and 'port'");
}

/// What Linux has names for from 300 baud on (termios.h), and what else UARTs and drives offer.
constexpr std::array<std::uint32_t, 30> kUsualRates = {
    300,    600,    1200,   1800,   2400,    4800,    9600,    14400,   19200,   28800,
    38400,  56000,  57600,  76800,  115200,  125000,  128000,  230400,  250000,  256000,
    460800, 500000, 576000, 921600, 1000000, 1152000, 1500000, 2000000, 3000000, 4000000};

/// By ratio, as a wrong digit changes a rate.
std::uint32_t nearest_rate(std::uint32_t rate) {
  const auto distance = [rate](std::uint32_t usual) {
    return std::abs(std::log(static_cast<double>(rate) / static_cast<double>(usual)));
  };
  return std::ranges::min(kUsualRates, {}, distance);
}

void check_rate(TomlTable& table, const bus::LineSettings& line) {
  const auto rate = static_cast<std::uint32_t>(line.baud);
  if (std::ranges::find(kUsualRates, rate) == kUsualRates.end()) {
    table.warning("baud", "{} is not a usual rate; did you mean {}?", rate, nearest_rate(rate));
  }
}

/// ttyS0, ttyUSB0, ttyACM0, ttyAMA0, ttymxc0: what the kernel calls a serial port.
bool is_kernel_name(std::string_view name) {
  return name.starts_with("tty") && name.back() >= '0' && name.back() <= '9';
}

/// Where a device of this relative path will be.
std::string below_dev(std::string_view path) {
  const auto name = path.substr(path.rfind('/') + 1);
  if (is_kernel_name(name)) {
    return fmt::format("/dev/{}", name);
  }
  constexpr std::string_view kDev = "dev/";
  return fmt::format("/dev/{}", path.substr(path.starts_with(kDev) ? kDev.size() : 0));
}

/// "./line-a" says itself that it is meant; "./ttyUSB0" is what a shell in /dev completes.
bool is_meant(std::string_view path) {
  return (path.starts_with("./") || path.starts_with("../")) &&
         !is_kernel_name(path.substr(path.rfind('/') + 1));
}

void check_path(TomlTable& table, const bus::LineSettings& line) {
  const std::string_view device = line.device;
  const bool relative =
      !device.empty() && !device.starts_with('/') && device.find("://") == std::string_view::npos;
  if (relative && !is_meant(device)) {
    table.warning("device",
                  "{} is relative to the folder in which mbgated is started; did you mean {}?",
                  in_quotes(device), in_quotes(below_dev(device)));
  }
}

}  // namespace

Lines read_line(TomlTable& table, bus::BusSettings& settings) {
  const bool moded = table.has("mode");
  const auto mode = table.word<Framing>("mode", kFramings);
  assign(settings.line.framing, mode);
  if (moded && !mode) {
    // Nobody can say which of these keys are right; none of them is unknown.
    table.accept(kSerialKeys);
    table.accept(kServerKeys);
    read_keys(table, bus_keys(), settings);
    return Lines::any;
  }
  if (settings.line.framing == Framing::tcp) {
    read_server(table, settings.line);
  } else {
    read_device(table, settings.line);
  }
  const Lines lines = lines_of(settings.line);
  read_keys(table, bus_keys(), settings, lines);
  if (lines != Lines::server) {
    read_serial(table, settings.line);
  }
  return lines;
}

void check_habits(TomlTable& table, const bus::LineSettings& line) {
  check_rate(table, line);
  check_path(table, line);
}

}  // namespace mbgate::config
