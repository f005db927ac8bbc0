// SPDX-License-Identifier: Apache-2.0
#include "config/profiles/profile_entries.hpp"
#include "config/sections/sections.hpp"
#include "config/toml/match_entry.hpp"

namespace mbgate::config {
namespace {

constexpr std::uint8_t kLoneServer = 255;

void read_bus(Draft& draft, TomlTable& table, drive::Device& device) {
  device.bus = drive::BusId{~0U};  // on no bus: its address clashes with nobody's but its like
  if (!table.require("bus")) {
    return;
  }
  if (const auto bus = find_named(table, "bus", draft.settings.buses)) {
    device.bus = drive::BusId{static_cast<std::uint32_t>(*bus)};
    device.timing = draft.settings.buses[*bus].timing;
  }
}

void read_timing(Draft& draft, TomlTable& table, drive::Device& device) {
  TimingOrigin origin;
  if (index(device.bus) < draft.buses.size()) {
    origin.has_identifiers = draft.settings.bus(device.bus).has_identifiers();
    origin.longest_quarantine = draft.buses[index(device.bus)].has("quarantine_max");
  }
  read_shared_timing(table, origin, device.timing);
}

/// Two devices of one address would answer at the same time.
void check_address_free(Draft& draft, const drive::Device& device) {
  const auto& all = draft.settings.devices;
  const auto same = std::ranges::find_if(all, [&](const drive::Device& other) {
    return other.bus == device.bus && other.address == device.address;
  });
  if (same != all.end()) {
    const auto first = static_cast<std::size_t>(same - all.begin());
    draft.devices.back().error("address", "{} on this bus is already used at {}", device.address,
                               draft.devices[first].place_of("address"));
  }
}

/// Serial Line V1.02, 2.2: 1 to 247; but there are devices at addresses that it reserves. A Modbus
/// TCP server takes any unit identifier, and one that is alone behind its connection answers to 255
/// (Messaging on TCP/IP V1.0b, 4.4.2.3).
void read_address(Draft& draft, TomlTable& table, drive::Device& device) {
  const bool tcp = is_tcp(draft, device.bus);
  if (tcp && !table.has("address")) {
    device.address = kLoneServer;
    check_address_free(draft, device);
    return;
  }
  table.require("address");
  const auto address = table.integer("address", tcp ? kUnits : IntegerRange{1, kUnits.max});
  device.address = static_cast<std::uint8_t>(address.value_or(0));
  if (address && index(device.bus) < draft.settings.buses.size()) {
    check_address_free(draft, device);
  }
}

void check_address_of_profile(const Draft& draft, TomlTable& table, const drive::Device& device) {
  const auto& profile = device.profile;
  if (device.address != 0 && !is_tcp(draft, device.bus) &&
      (device.address < profile.first_address || device.address > profile.last_address)) {
    table.warning("address", "{} is not an address of {}, which has {} to {}", device.address,
                  in_quotes(profile.name), profile.first_address, profile.last_address);
  }
}

/// The address of a profile's own form of broadcasts cannot be that of a device.
void check_broadcast_address(Draft& draft) {
  const auto& devices = draft.settings.devices;
  for (std::size_t i = 0; i < devices.size(); ++i) {
    const auto hearer = std::ranges::find_if(devices, [&](const drive::Device& other) {
      return other.bus == devices[i].bus && other.profile.broadcast.has_own_form() &&
             other.profile.broadcast.form->address == devices[i].address;
    });
    if (hearer != devices.end()) {
      draft.devices[i].error("address",
                             "{} is the address of broadcasts on this bus ({} receives them there)",
                             devices[i].address, in_quotes(hearer->name));
    }
  }
}

/// Which devices are all that their bus has, whatever the unit.
void read_every_unit(Draft& draft) {
  auto& settings = draft.settings;
  for (std::size_t at = 0; at < settings.buses.size(); ++at) {
    const auto is_there = [&](const drive::Device& it) { return index(it.bus) == at; };
    const auto count = std::ranges::count_if(settings.devices, is_there);
    const auto device = std::ranges::find_if(settings.devices, is_there);
    const auto& stated = settings.buses[at].one_device;
    if (stated == true && count != 1) {
      draft.buses[at].error(
          "one_device", "true needs one [[device]] with this bus, and no other: found {}", count);
    } else if (count == 1 && settings.buses[at].line.framing == bus::Framing::tcp) {
      device->has_every_unit = stated.value_or(device->address == kLoneServer);
    }
  }
}

/// The profile that the device names; nullptr if it names none or a wrong one.
const ProfileFile* read_profile(Draft& draft, TomlTable& table, drive::Device& device) {
  const auto name = table.string("profile");
  draft.profile_known.push_back(!table.has("profile"));
  if (!name) {
    return nullptr;
  }
  if (!draft.library.knows(*name)) {
    table.error("profile", unknown_profile(draft.library, *name));
    return nullptr;
  }
  const auto* file = draft.library.find(*name);
  if (file != nullptr) {
    draft.profile_known.back() = true;
    device.profile = file->profile;
    device.timing.response_wait = file->profile.response_wait;
    const bool stated = index(device.bus) < draft.buses.size() &&
                        draft.buses[index(device.bus)].has("response_timeout");
    if (!stated) {  // what its user says of the line, the profile cannot know
      assign(device.timing.response_timeout, file->profile.response_timeout);
    }
  }
  return file;
}

void read_orders(Draft& draft, TomlTable& table, drive::Device& device) {
  const auto& profile = device.profile;
  const bool known = draft.profile_known.back();
  const auto order = table.word<drive::WordOrder>("word_order", kWordOrders);
  if (order && profile.word_order && *order != *profile.word_order) {
    table.error("word_order", "{} drives have {}, and it cannot be set", in_quotes(profile.name),
                in_quotes(order_word(*profile.word_order)));
  }
  device.word_order = order ? order : profile.word_order;
  device.opcode_order = table.word<drive::WordOrder>("opcode_order", kWordOrders);
  if (device.opcode_order && known && !profile.position_opcodes) {
    table.error("opcode_order", in_quotes(profile.name) + " has no opcodes that carry a position");
  }
  if (!device.verify_word_order || !known) {
    return;
  }
  if (!profile.word_order_register) {
    table.error("verify_word_order",
                in_quotes(profile.name) + " names no register that holds the word order");
  } else if (!table.has("word_order")) {
    table.error("verify_word_order", "needs 'word_order', the expected setting");
  }
}

void read_writing(Draft& draft, TomlTable& table, drive::Device& device) {
  assign(device.limits_values, table.word<bool>("write_echo", kEchoes));
  const auto& profile = device.profile;
  const auto function = read_write_function(table);
  if (function && draft.profile_known.back() && !profile.functions.test(*function)) {
    table.error("write_function", "{} has no function {}", in_quotes(profile.name), *function);
  }
  if (function == 6 && profile.position_opcodes) {
    table.error("write_function",
                "{} carries an opcode out as soon as it is written: a run of 06 would write its "
                "parameters too late",
                in_quotes(profile.name));
  }
  device.write_function = function;  // a maker's preference alone changes no request
  if (device.split_values && device.write_function != 6) {
    table.warning("split_values", "does nothing without write_function = 6");
  }
}

// Each part of a run would have to be a stop: its parameters alone are none, and come too late.
void check_stops(TomlTable& table, const drive::Device& device) {
  const auto& profile = device.profile;
  if (device.write_function == 6 && !profile.position_opcodes &&
      std::ranges::any_of(profile.stops, [](const auto& stop) { return stop.parameters > 0; })) {
    table.error("write_function",
                "{} has a stop with parameters, which only 16 carries in one: a run of 06 would "
                "write them after the stop",
                in_quotes(device.name));
  }
}

}  // namespace

void read_devices(Draft& draft) {
  for (auto table : draft.document.root().tables("device")) {
    drive::Device device;
    draft.devices.push_back(table);
    device.name = read_name(draft.devices, draft.settings.devices);
    read_bus(draft, table, device);
    read_address(draft, table, device);
    read_drive(draft, table, device);
    read_timing(draft, table, device);
    check_address_of_profile(draft, table, device);
    draft.settings.guards.push_back(read_guard(draft, table, device));
    draft.settings.devices.push_back(std::move(device));
  }
  check_broadcast_address(draft);
  read_every_unit(draft);
}

void read_drive(Draft& draft, TomlTable& table, drive::Device& device) {
  const auto* file = read_profile(draft, table, device);
  read_keys(table, device_keys(), device);
  read_orders(draft, table, device);
  read_writing(draft, table, device);
  read_own_values(table, file, device);
  read_own_stops(table, device);
  check_stops(table, device);
}

}  // namespace mbgate::config
