// SPDX-License-Identifier: Apache-2.0
// The line of a bus: a serial port, a serial device server behind TCP, or a Modbus TCP server.
#include <array>
#include <charconv>
#include <limits>

#include "config/sections.hpp"

namespace mbgate::config {
namespace {

using bus::Framing;
using modbus::Parity;
using namespace std::chrono_literals;

constexpr std::array kModes = {Word{"rtu", Framing::rtu}, Word{"ascii", Framing::ascii},
                               Word{"tcp", Framing::tcp}};
constexpr std::array kParities = {Word{"none", Parity::none}, Word{"even", Parity::even},
                                  Word{"odd", Parity::odd}};
constexpr std::array kDirections = {
    Word{"off", bus::Rs485::off}, Word{"kernel", bus::Rs485::kernel}, Word{"rts", bus::Rs485::rts}};

/// A server takes 1 to 16 transactions at a time (Messaging on TCP/IP V1.0b, 4.3.2,
/// NumberMaxOfServerTransaction): more would only wait there instead of here.
constexpr std::int64_t kMostOutstanding = 16;
constexpr std::string_view kScheme = "tcp://";

/// Keys of serial lines; RTU and ASCII over TCP have them too.
constexpr std::array kSerialKeys = {"device",
                                    "baud",
                                    "data_bits",
                                    "parity",
                                    "stop_bits",
                                    "rs485",
                                    "rs485_rts_on_send",
                                    "rs485_delay_before",
                                    "rs485_delay_after",
                                    "echo",
                                    "paced",
                                    "low_latency",
                                    "frame_gap",
                                    "frame_slack",
                                    "turnaround",
                                    "listen_first",
                                    "settle"};
/// The longest that Linux takes (serial_core.c, RS485_MAX_RTS_DELAY).
constexpr std::chrono::milliseconds kLongestDelay = 100ms;

/// Keys of a Modbus TCP server, and of whatever is reached by a TCP connection.
constexpr std::array kServerKeys = {"host", "port", "outstanding", "check_unit", "replace_after"};
constexpr std::array kConnectionKeys = {"connect_timeout", "acknowledge_timeout", "idle_probe"};

/// "host:port", "[::1]:port".
std::optional<bus::Endpoint> parse_endpoint(std::string_view text) {
  const auto colon = text.rfind(':');
  if (colon == std::string_view::npos) {
    return std::nullopt;
  }
  auto host = text.substr(0, colon);
  const auto digits = text.substr(colon + 1);
  bus::Endpoint endpoint;
  const auto* end = digits.data() + digits.size();
  const auto [at, error] = std::from_chars(digits.data(), end, endpoint.port);
  if (error != std::errc{} || at != end || endpoint.port == 0) {
    return std::nullopt;
  }
  const bool bracketed = host.starts_with('[') && host.ends_with(']');
  if (bracketed) {
    host = host.substr(1, host.size() - 2);
  }
  if (host.empty() || bracketed != (host.find(':') != std::string_view::npos) ||
      host.find_first_of("/[]@ ") != std::string_view::npos) {
    return std::nullopt;
  }
  endpoint.host = host;
  return endpoint;
}

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
  if (device.starts_with(kScheme)) {
    line.remote = parse_endpoint(device.substr(kScheme.size()));
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
    table.error("data_bits",
                "ASCII characters have 7 or 8 data bits, found " + std::to_string(*data_bits));
  } else if (data_bits && !ascii && *data_bits != 8) {
    table.error("data_bits", "RTU characters have 8 data bits (Serial Line V1.02, 2.5.1), found " +
                                 std::to_string(*data_bits));
  } else {
    assign(line.format.data_bits, data_bits);
  }
  assign(line.format.parity, table.word<Parity>("parity", kParities));
  assign(line.format.stop_bits, table.integer("stop_bits", {1, 2}));
}

/// How the kernel turns the line round, where it is told otherwise than by the device tree.
void read_direction(TomlTable& table, bus::LineSettings& line) {
  assign(line.rs485, table.word<bus::Rs485>("rs485", kDirections));
  assign(line.rs485_rts_on_send, table.boolean("rs485_rts_on_send"));
  assign(line.rs485_delay_before, table.duration("rs485_delay_before", {0ms, kLongestDelay}));
  assign(line.rs485_delay_after, table.duration("rs485_delay_after", {0ms, kLongestDelay}));
  for (const auto& [key, delay] : {std::pair{"rs485_delay_before", line.rs485_delay_before},
                                   std::pair{"rs485_delay_after", line.rs485_delay_after}}) {
    if (delay && *delay % 1ms != 0ms) {
      table.report_expected(key, *table.value(key), "whole milliseconds");
    }
  }
  for (const auto* key : {"rs485_rts_on_send", "rs485_delay_before", "rs485_delay_after"}) {
    if (table.has(key) && line.rs485 != bus::Rs485::kernel) {
      table.error(key, "belongs to rs485 = \"kernel\"");
    }
  }
}

void read_connection(TomlTable& table, bus::ConnectionTimes& times) {
  assign(times.connect_timeout, table.duration("connect_timeout", {100ms, 1min}));
  assign(times.acknowledge_timeout, table.duration("acknowledge_timeout", {100ms, 1min}));
  const auto probe = table.duration("idle_probe", {2s, 1h});
  times.idle_probe =
      std::chrono::duration_cast<std::chrono::seconds>(probe.value_or(times.idle_probe));
  if (probe && times.idle_probe != *probe) {
    table.report_expected("idle_probe", *table.value("idle_probe"), "whole seconds");
  }
}

/// What only a serial port of this machine has, and what it has not.
void check_remote(TomlTable& table, bus::LineSettings& line) {
  if (!line.remote) {
    for (const auto* key : kConnectionKeys) {
      if (table.has(key)) {
        table.error(key,
                    "belongs to a TCP connection: mode = \"tcp\", or device = "
                    "\"tcp://host:port\"");
      }
    }
    return;
  }
  read_connection(table, line.connection);
  if (line.rs485 != bus::Rs485::off) {
    table.error("rs485", "the serial device server turns its line round itself: expected \"off\"");
  }
  if (table.has("low_latency")) {
    table.error("low_latency", "belongs to a serial port of this machine");
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
  read_device(table, line);
  assign(line.baud, table.integer("baud", {1, std::numeric_limits<std::uint32_t>::max()}));
  read_character(table, line);
  read_direction(table, line);
  read_switch(table, "echo", line.echo);
  read_switch(table, "paced", line.paced);
  assign(line.low_latency, table.boolean("low_latency"));
  check_remote(table, line);
  check_habits(table, line);
  for (const auto* key : {"host", "port"}) {
    if (table.has(key)) {
      table.error(key,
                  "belongs to mode = \"tcp\"; a serial device server is device = "
                  "\"tcp://host:port\"");
    }
  }
  if (table.has("outstanding")) {
    table.error("outstanding",
                "belongs to mode = \"tcp\": a serial line carries one request at a time");
  }
  for (const auto* key : {"check_unit", "replace_after"}) {
    if (table.has(key)) {
      table.error(key, "belongs to mode = \"tcp\"");
    }
  }
}

void read_server(TomlTable& table, bus::BusSettings& settings) {
  bus::Endpoint server;
  if (table.require("host")) {
    assign(server.host, table.string("host"));
    if (server.host.empty() && std::get_if<std::string>(&table.value("host")->data) != nullptr) {
      table.error("host", "expected a name or an address, found an empty string");
    }
  }
  assign(server.port, table.integer("port", {1, 65535}));
  settings.line.remote = std::move(server);
  assign(settings.outstanding, table.integer("outstanding", {1, kMostOutstanding}));
  assign(settings.check_unit, table.boolean("check_unit"));
  assign(settings.replace_after, table.integer("replace_after", {0, 1000}));
  read_connection(table, settings.line.connection);
  for (const auto* key : kSerialKeys) {
    if (table.has(key)) {
      table.error(key, "belongs to a serial line; a Modbus TCP server has 'host' and 'port'");
    }
  }
}

}  // namespace

void read_line(TomlTable& table, bus::BusSettings& settings) {
  const bool moded = table.has("mode");
  const auto mode = table.word<Framing>("mode", kModes);
  assign(settings.line.framing, mode);
  if (moded && !mode) {
    // Nobody can say which of these keys are right; none of them is unknown.
    for (const auto* key : kSerialKeys) {
      table.has(key);
    }
    for (const auto* key : kServerKeys) {
      table.has(key);
    }
    for (const auto* key : kConnectionKeys) {
      table.has(key);
    }
  } else if (settings.line.framing == Framing::tcp) {
    read_server(table, settings);
  } else {
    read_serial(table, settings.line);
  }
}

}  // namespace mbgate::config
