// SPDX-License-Identifier: Apache-2.0
#include "config/sections.hpp"

namespace mbgate::config {
namespace {

using namespace std::chrono_literals;

void read_bus(Draft& draft, TomlTable& table, drive::Device& device) {
  if (!table.require("bus")) {
    return;
  }
  if (const auto bus = find_named(table, "bus", draft.settings.buses)) {
    device.bus = drive::BusId{static_cast<std::uint32_t>(*bus)};
    device.timing = draft.settings.buses[*bus].timing;
  } else {
    device.bus = drive::BusId{~0U};  // on no bus: its address clashes with nobody's but its like
  }
}

void read_timing(TomlTable& table, drive::DeviceTiming& timing) {
  assign(timing.response_timeout, table.duration("response_timeout", {1ms, 1h}));
  assign(timing.response_wait, table.duration("response_wait", {0s, 1min}));
  assign(timing.gap, table.duration("gap", {0s, 1min}));
  assign(timing.retries, table.integer("retries", {0, 100}));
  assign(timing.retry_writes, table.boolean("retry_writes"));
}

/// Two devices of one address would answer at the same time.
void check_address(Draft& draft, const drive::Device& device) {
  const auto& all = draft.settings.devices;
  const auto same = std::ranges::find_if(all, [&](const drive::Device& other) {
    return other.bus == device.bus && other.address == device.address;
  });
  if (same != all.end()) {
    const auto first = static_cast<std::size_t>(same - all.begin());
    draft.devices.back().error(
        "address", std::to_string(device.address) + " on this bus is taken already at " +
                       place(draft.document, draft.devices[first].value_position("address")));
  }
}

}  // namespace

void read_devices(Draft& draft) {
  for (auto table : draft.document.root().tables("device")) {
    drive::Device device;
    draft.devices.push_back(table);
    device.name = read_name(table);
    check_name(draft.devices, draft.settings.devices, device.name);
    read_bus(draft, table, device);
    table.require("address");
    const auto address = table.integer("address", {1, 247});
    device.address = static_cast<std::uint8_t>(address.value_or(0));
    if (address && index(device.bus) < draft.settings.buses.size()) {
      check_address(draft, device);
    }
    read_timing(table, device.timing);
    draft.settings.devices.push_back(std::move(device));
  }
}

}  // namespace mbgate::config
