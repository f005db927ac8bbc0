// SPDX-License-Identifier: Apache-2.0
#include "sim/settings.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "config/toml_reader.hpp"

namespace mbgate::sim {
namespace {

using config::TomlDocument;
using config::TomlTable;
using config::Word;
using modbus::Parity;
using namespace std::chrono_literals;

constexpr std::array kParities = {Word{"none", Parity::none}, Word{"even", Parity::even},
                                  Word{"odd", Parity::odd}};
constexpr std::array kModes = {Word{"rtu", Framing::rtu}, Word{"ascii", Framing::ascii}};
constexpr std::array kModels = {Word{"moons", ModelKind::moons},
                                Word{"stepper", ModelKind::stepper}, Word{"aic", ModelKind::aic},
                                Word{"fda6000", ModelKind::fda6000}};
constexpr std::array kSeries = {Word{"st", MoonsSeries::st},   Word{"stb", MoonsSeries::stb},
                                Word{"stf", MoonsSeries::stf}, Word{"ssdc", MoonsSeries::ssdc},
                                Word{"m2", MoonsSeries::m2},   Word{"m3", MoonsSeries::m3},
                                Word{"mdx", MoonsSeries::mdx}, Word{"bldc", MoonsSeries::bldc}};
constexpr std::array kOrders = {Word{"big", drive::WordOrder::big},
                                Word{"little", drive::WordOrder::little}};

std::string read_name(TomlTable& table) {
  table.require("name");
  const auto name = table.string("name");
  if (name && name->empty()) {
    table.error("name", "expected a name, found an empty string");
  }
  return name.value_or("");
}

template <typename Named>
void check_unique(TomlTable& table, const std::vector<Named>& earlier, const std::string& name) {
  const bool taken = std::ranges::any_of(
      earlier, [&name](const Named& other) { return !name.empty() && other.name == name; });
  if (taken) {
    table.error("name", '"' + name + "\" is taken already");
  }
}

// Serial Line V1.02: a character of RTU has 8 data bits (2.5.1), one of ASCII 7 (2.5.2); some
// devices take 8 for ASCII too.
void read_framing(TomlTable& table, WireSettings& wire) {
  config::assign(wire.framing, table.word<Framing>("mode", kModes));
  const bool ascii = wire.framing == Framing::ascii;
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
  config::assign(wire.format.parity, table.word<Parity>("parity", kParities));
  read_framing(table, wire);
  config::assign(wire.format.stop_bits, table.integer("stop_bits", {1, 2}));
  config::assign(wire.adapter_latency, table.duration("adapter_latency", {0s, 1s}));
  wire.gap = table.duration("gap", {0s, 1s});
  config::assign(wire.echo, table.boolean("echo"));
  config::assign(wire.paced, table.boolean("paced"));
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
  config::assign(device.word_order, table.word<drive::WordOrder>("word_order", kOrders));
  config::assign(device.series, table.word<MoonsSeries>("series", kSeries));
  for (const std::string_view key : {"word_order", "series"}) {
    if (model && *model != ModelKind::moons && table.has(key)) {
      table.error(key, "only a \"moons\" drive has one to be set");
    }
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

DeviceSettings read_device(TomlTable& table) {
  DeviceSettings device;
  device.name = read_name(table);
  table.require("address");
  config::assign(device.address, table.integer("address", {1, modbus::kMaxDeviceAddress}));
  read_model(table, device);
  read_times(table, device);
  read_faults(table, device.faults);
  return device;
}

std::vector<BusSettings> read_buses(TomlTable root) {
  std::vector<BusSettings> buses;
  for (TomlTable table : root.tables("bus")) {
    BusSettings bus;
    bus.name = read_name(table);
    check_unique(table, buses, bus.name);
    table.require("link");
    bus.link = table.string("link").value_or("");
    if (bus.link.empty() && table.has("link")) {
      table.error("link", "expected the path of the link to make");
    }
    const bool taken = std::ranges::any_of(
        buses, [&bus](const BusSettings& other) { return other.link == bus.link; });
    if (taken && !bus.link.empty()) {
      table.error("link", '"' + bus.link.string() + "\" is taken already");
    }
    read_wire(table, bus.wire);
    buses.push_back(std::move(bus));
  }
  if (buses.empty()) {
    root.document().error({}, "there is no [[bus]]: nothing to simulate");
  }
  return buses;
}

void place_device(TomlTable& table, const DeviceSettings& device, std::vector<BusSettings>& buses) {
  table.require("bus");
  const auto name = table.string("bus");
  const auto bus = std::ranges::find_if(
      buses, [&name](const BusSettings& candidate) { return name && candidate.name == *name; });
  if (bus == buses.end()) {
    if (name) {
      table.error("bus", "there is no bus \"" + *name + '"');
    }
    return;
  }
  const bool taken = std::ranges::any_of(bus->devices, [&device](const DeviceSettings& other) {
    return other.address == device.address;
  });
  if (taken && table.has("address")) {
    table.error("address",
                std::to_string(device.address) + " is taken already on bus \"" + bus->name + '"');
  }
  bus->devices.push_back(device);
}

Loaded read(TomlDocument document) {
  Settings settings;
  if (document.parsed()) {
    TomlTable root = document.root();
    config::assign(settings.reopen_after, root.duration("reopen_after", {0s, 1h}));
    settings.buses = read_buses(root);
    std::vector<DeviceSettings> devices;
    for (TomlTable table : root.tables("device")) {
      const DeviceSettings device = read_device(table);
      check_unique(table, devices, device.name);
      devices.push_back(device);
      place_device(table, device, settings.buses);
    }
  }
  Loaded loaded{std::nullopt, document.finish()};
  if (!config::has_errors(loaded.diagnostics)) {
    loaded.settings = std::move(settings);
  }
  return loaded;
}

}  // namespace

Loaded load_settings(const std::filesystem::path& path) { return read(TomlDocument::load(path)); }

Loaded load_settings_text(std::string name, std::string_view text) {
  return read(TomlDocument::parse(std::move(name), text));
}

}  // namespace mbgate::sim
