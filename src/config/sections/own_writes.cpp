// SPDX-License-Identifier: Apache-2.0
// Writes that a user names at a device: stops = [{ address = 200, value = 0 }], and
// failsafe = [{ address = 124, value = 0xE2 }].
#include <array>
#include <string>

#include "config/sections/sections.hpp"
#include "config/toml/match_entry.hpp"
#include "modbus/request.hpp"

namespace mbgate::config {
namespace {

using drive::Device;
using modbus::Request;
using modbus::Table;

/// They go before everything else on their bus, one after the other.
constexpr std::size_t kMostFailsafe = 16;

/// The functions that write one coil or register, and several.
struct WriteFunctions {
  std::uint8_t single;
  std::uint8_t multiple;
};

WriteFunctions functions_for(Table table) {
  return table == Table::coils ? WriteFunctions{5, 15} : WriteFunctions{6, 16};
}

/// `table` and `address` of an entry, "holding" unless told; nothing if one of them is wrong.
std::optional<modbus::TableRange> read_place(TomlTable& entry) {
  const bool named = entry.has("table");
  const auto table = entry.word<Table>("table", kWritableTables);
  entry.require("address");
  const auto address = entry.integer("address", kRegisterAddresses);
  if ((named && !table) || !address) {
    return std::nullopt;
  }
  return modbus::TableRange{table.value_or(Table::holding_registers),
                            static_cast<std::uint16_t>(*address), 1};
}

/// Reports a place that the device would not let be written alone.
void check_place(TomlTable& entry, const Device& device, const modbus::TableRange& range) {
  const auto& profile = device.profile;
  const auto functions = functions_for(range.table);
  const auto address = std::to_string(range.first);
  if (const auto* value = profile.values.at(range.table, range.first)) {
    entry.error("address",
                "{} is a register of the value {} to {}: a part of it cannot be written alone",
                address, value->first, value->end() - 1);
  } else if (drive::touches(profile.read_only, range)) {
    entry.error("address", "{} is read-only in {}", address, in_quotes(profile.name));
  } else if (!profile.functions.test(functions.single) &&
             !profile.functions.test(functions.multiple)) {
    entry.error(entry.has("table") ? "table" : "address", "{} has neither function {} nor {}",
                in_quotes(profile.name), functions.single, functions.multiple);
  }
}

/// What is written to a coil: true and false, or as on the wire.
std::optional<std::uint16_t> read_coil(TomlTable& entry) {
  const auto* found = entry.value("value");
  if (found == nullptr) {
    return std::nullopt;
  }
  if (const auto* on = std::get_if<bool>(&found->data)) {
    return *on ? kCoilOn : std::uint16_t{0};
  }
  const auto* number = std::get_if<std::int64_t>(&found->data);
  if (number != nullptr && (*number == 0 || *number == kCoilOn)) {
    return static_cast<std::uint16_t>(*number);
  }
  entry.report_expected("value", *found, "true, false, 0xFF00 or 0");
  return std::nullopt;
}

/// The write in the function that the device has, and where it can choose, in the one it is given
/// by its `write_function`.
Request write_as_taken(const Device& device, const modbus::TableRange& range, std::uint16_t value) {
  const auto functions = functions_for(range.table);
  const bool multiple = device.write_function == functions.multiple ||
                        !device.profile.functions.test(functions.single);
  return modbus::make_write(range.table, range.first, std::array{value}, multiple);
}

std::optional<Request> read_failsafe_write(TomlTable& entry, const Device& device) {
  const auto range = read_place(entry);
  entry.require("value");
  if (!range) {
    return std::nullopt;
  }
  std::optional<std::uint16_t> value;
  if (range->table == Table::coils) {
    value = read_coil(entry);
  } else {
    assign(value, entry.integer("value", kRegisterValues));
  }
  check_place(entry, device, *range);
  if (!value) {
    return std::nullopt;
  }
  auto request = write_as_taken(device, *range, *value);
  if (device.is_reconfigured_by(request) && !device.allow_reconfigure) {
    entry.error("address",
                "{} changes the communication of the drive: needs allow_reconfigure = true",
                range->first);
  }
  return request;
}

}  // namespace

void read_own_stops(TomlTable& table, drive::Device& device) {
  for (auto& entry : table.tables("stops")) {
    const auto range = read_place(entry);
    drive::WriteMatch match;
    if (range) {
      match.table = range->table;
      match.address = range->first;
    }
    read_written(entry, false, match);
    read_parameters(entry, match);
    if (range) {
      check_place(entry, device, *range);
      device.profile.stops.push_back(match);
    }
  }
}

std::vector<modbus::Request> read_failsafe(TomlTable& table, const drive::Device& device) {
  std::vector<Request> writes;
  for (auto& entry : table.tables("failsafe")) {
    if (auto request = read_failsafe_write(entry, device)) {
      writes.push_back(*std::move(request));
    }
  }
  if (writes.size() > kMostFailsafe) {
    table.error("failsafe", "expected at most {} writes, found {}", kMostFailsafe, writes.size());
  }
  return writes;
}

}  // namespace mbgate::config
