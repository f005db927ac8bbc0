// SPDX-License-Identifier: Apache-2.0
#include "sim/program/settings.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "config/sections/sections.hpp"

template <>
inline constexpr std::string_view mbgate::config::kSection<mbgate::sim::BusSettings> = "[[bus]]";

namespace mbgate::sim {
namespace {

using config::TomlDocument;
using config::TomlTable;
using config::Word;
using modbus::Parity;
using namespace std::chrono_literals;

constexpr std::array kModes = {Word{"rtu", BusMode::rtu}, Word{"ascii", BusMode::ascii},
                               Word{"tcp", BusMode::tcp}};
constexpr std::array kModels = {Word{"moons", ModelKind::moons},
                                Word{"stepper", ModelKind::stepper}, Word{"aic", ModelKind::aic},
                                Word{"fda6000", ModelKind::fda6000}};
constexpr std::array kSeries = {Word{"st", MoonsSeries::st},   Word{"stb", MoonsSeries::stb},
                                Word{"stf", MoonsSeries::stf}, Word{"ssdc", MoonsSeries::ssdc},
                                Word{"m2", MoonsSeries::m2},   Word{"m3", MoonsSeries::m3},
                                Word{"mdx", MoonsSeries::mdx}, Word{"bldc", MoonsSeries::bldc}};

// Serial Line V1.02: a character of RTU has 8 data bits (2.5.1), one of ASCII 7 (2.5.2); some
// devices take 8 for ASCII too.
void read_framing(TomlTable& table, BusMode mode, WireSettings& wire) {
  const bool ascii = mode == BusMode::ascii;
  wire.framing = ascii ? Framing::ascii : Framing::rtu;
  wire.format.data_bits = ascii ? 7 : 8;
  config::assign(wire.format.data_bits, table.integer("data_bits", {7, 8}));
  if (!ascii && wire.format.data_bits != 8) {
    table.error("data_bits", "an RTU bus has 8");
  }
  if (ascii && table.has("gap")) {
    table.error("gap", "an ASCII bus needs no silence between frames");
  }
}

void read_wire(TomlTable& table, WireSettings& wire) {
  config::assign(wire.baud, table.integer("baud", {1, std::numeric_limits<std::uint32_t>::max()}));
  config::assign(wire.format.parity, table.word<Parity>("parity", config::kParities));
  config::assign(wire.format.stop_bits, table.integer("stop_bits", {1, 2}));
  config::assign(wire.adapter_latency, table.duration("adapter_latency", {0s, 1s}));
  wire.gap = table.duration("gap", {0s, 1s});
  config::assign(wire.echo, table.boolean("echo"));
  config::assign(wire.echo_delay, table.duration("echo_delay", {0s, 1s}));
  if (table.has("echo_delay") && !wire.echo) {
    table.error("echo_delay", "belongs to a bus with echo = true");
  }
  wire.clocking = Clocking::real_time;
}

void read_faults(TomlTable& device, Faults& faults) {
  auto table = device.table("faults");
  if (!table) {
    return;
  }
  config::assign(faults.silent, table->boolean("silent"));
  faults.answer_after = table->duration("answer_after", {0s, 1h});
  config::assign(faults.bad_crc, table->boolean("bad_crc"));
  config::assign(faults.wrong_unit, table->boolean("wrong_unit"));
  config::assign(faults.wrong_function, table->boolean("wrong_function"));
  config::assign(faults.exception_every, table->integer("exception_every", {1, 1'000'000}));
}

void read_model(TomlTable& table, DeviceSettings& device) {
  table.require("model");
  const auto model = table.word<ModelKind>("model", kModels);
  config::assign(device.model, model);
  config::assign(device.word_order,
                 table.word<drive::WordOrder>("word_order", config::kWordOrders));
  config::assign(device.series, table.word<MoonsSeries>("series", kSeries));
  if (model && *model != ModelKind::moons) {
    table.reject({"word_order", "series"}, "belongs to a \"moons\" drive");
  }
}

// The AiC keeps its wait in a register, in milliseconds (405204); the others' is not limited by the
// model.
void read_times(TomlTable& table, DeviceSettings& device) {
  device.processing = table.duration("processing", {0s, 1min});
  if (device.model != ModelKind::aic) {
    device.response_wait = table.duration("response_wait", {0s, 1min});
    return;
  }
  device.response_wait = table.duration("response_wait", {1ms, 99ms});
  if (device.response_wait && *device.response_wait % 1ms != 0ns) {
    table.error("response_wait", "an AiC counts its waiting time in whole milliseconds");
  }
}

// On Ethernet a drive is the only one behind its address, so its unit identifier need not be given.
void read_unit(TomlTable& table, BusMode mode, std::uint8_t& address) {
  if (mode == BusMode::tcp) {
    address = 255;
    config::assign(address, table.integer("address", {0, 255}));
    return;
  }
  table.require("address");
  config::assign(address, table.integer("address", {1, modbus::kMaxDeviceAddress}));
}

DeviceSettings read_device(TomlTable& table, BusMode mode) {
  DeviceSettings device;
  read_unit(table, mode, device.address);
  read_model(table, device);
  read_times(table, device);
  read_faults(table, device.faults);
  if (mode == BusMode::tcp && device.faults.bad_crc) {
    table.error("faults", "the frames of a \"tcp\" bus have no CRC");
  }
  return device;
}

void read_link(TomlTable& table, const std::vector<BusSettings>& buses, BusSettings& bus) {
  table.require("link");
  bus.link = table.string("link").value_or("");
  if (bus.link.empty() && table.has("link")) {
    table.error("link", "expected the path of the link to make");
  }
  const bool taken = std::ranges::any_of(
      buses, [&bus](const BusSettings& other) { return other.link == bus.link; });
  if (taken && !bus.link.empty()) {
    table.error("link", "\"{}\" is already used", bus.link.string());
  }
}

void read_listen(TomlTable& table, const std::vector<BusSettings>& buses, BusSettings& bus) {
  if (table.has("link")) {
    table.error("link", "a bus that listens has no link");
  }
  const auto text = table.string("listen");
  bus.listen = text ? ListenAddress::parse(*text) : ListenAddress{};
  if (!bus.listen) {
    table.report_expected("listen", *table.value("listen"),
                          R"(an IPv4 address and a port, such as "127.0.0.1:0")");
    return;
  }
  const bool taken = std::ranges::any_of(
      buses, [&bus](const BusSettings& other) { return other.listen == bus.listen; });
  if (taken && bus.listen->port != 0) {
    table.error("listen", "\"{}\" is already used", bus.listen->text());
  }
}

BusSettings read_bus(std::vector<TomlTable>& tables, const std::vector<BusSettings>& buses) {
  TomlTable& table = tables.back();
  BusSettings bus{.name = config::read_name(tables, buses)};
  config::assign(bus.mode, table.word<BusMode>("mode", kModes));
  if (bus.mode == BusMode::tcp || table.has("listen")) {
    read_listen(table, buses, bus);
  } else {
    read_link(table, buses, bus);
  }
  config::assign(bus.wire.paced, table.boolean("paced"));
  if (bus.mode == BusMode::tcp) {
    table.reject({"baud", "parity", "data_bits", "stop_bits", "adapter_latency", "gap", "echo",
                  "echo_delay"},
                 "a \"tcp\" bus is not a serial line");
  } else {
    read_framing(table, bus.mode, bus.wire);
    read_wire(table, bus.wire);
  }
  return bus;
}

std::vector<BusSettings> read_buses(TomlTable root) {
  std::vector<BusSettings> buses;
  std::vector<TomlTable> tables;
  for (const TomlTable& table : root.tables("bus")) {
    tables.push_back(table);
    buses.push_back(read_bus(tables, buses));
  }
  if (buses.empty()) {
    root.document().error({}, "there is no [[bus]]: nothing to simulate");
  }
  return buses;
}

void place_device(TomlTable& table, const DeviceSettings& device, BusSettings& bus) {
  const bool taken = std::ranges::any_of(bus.devices, [&device](const DeviceSettings& other) {
    return other.address == device.address;
  });
  if (taken && (table.has("address") || bus.mode == BusMode::tcp)) {
    table.error("address", "{} is already used on bus \"{}\"", device.address, bus.name);
  }
  bus.devices.push_back(device);
}

void read_devices(TomlTable root, std::vector<BusSettings>& buses) {
  std::vector<DeviceSettings> devices;
  std::vector<TomlTable> tables;
  for (TomlTable table : root.tables("device")) {
    tables.push_back(table);
    table.require("bus");
    const auto bus = config::find_named(table, "bus", buses);
    DeviceSettings device = read_device(table, bus ? buses[*bus].mode : BusMode::rtu);
    device.name = config::read_name(tables, devices);
    devices.push_back(device);
    if (bus) {
      place_device(table, device, buses[*bus]);
    }
  }
}

Loaded read(TomlDocument document) {
  Settings settings;
  if (document.parsed()) {
    TomlTable root = document.root();
    config::assign(settings.reopen_after, root.duration("reopen_after", {0s, 1h}));
    settings.buses = read_buses(root);
    read_devices(root, settings.buses);
  }
  Loaded loaded{std::nullopt, document.finish()};
  if (!config::has_errors(loaded.diagnostics)) {
    loaded.settings = std::move(settings);
  }
  return loaded;
}

}  // namespace

Loaded load_settings(const config::TextFile& file) { return read(TomlDocument::parse({file})); }

}  // namespace mbgate::sim
