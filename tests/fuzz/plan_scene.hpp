// SPDX-License-Identifier: Apache-2.0
// Drives, a route and what they are asked, of any bytes; consistent as the configuration makes
// them.
#pragma once

#include <deque>

#include "fuzz/client_view.hpp"
#include "fuzz/fuzz.hpp"
#include "routing/route.hpp"

namespace mbgate::fuzz {

using drive::BroadcastForm;
using drive::WordOrder;

inline constexpr std::uint8_t kFirstUnit = 1;
inline constexpr std::uint8_t kLastUnit = 8;
inline constexpr std::uint8_t kFirstAddress = 11;  ///< of the first unit

/// Addresses that meet: the lowest ones, and those at the end of a table.
inline std::uint16_t place_of(Script& script) {
  const std::uint8_t low = script.byte();
  return static_cast<std::uint16_t>(low < 0xF0 ? low : 0xFF00U | low);
}

inline WordOrder order_of(Script& script) {
  return script.flag() ? WordOrder::big : WordOrder::little;
}

/// A value is never over a limit, no group cuts one.
inline void read_profile(Script& script, drive::Profile& profile) {
  const std::uint8_t values = script.byte() % 16;
  for (int value = 0; value < values; ++value) {
    const auto table = script.flag() ? Table::holding_registers : Table::input_registers;
    const auto registers = static_cast<std::uint8_t>(script.flag() ? 4 : 2);
    const std::uint16_t first = std::min<std::uint16_t>(place_of(script), 0xFFFC);
    profile.values.add({table, first, registers, script.flag()});
  }
  profile.limits.read[2] = static_cast<std::uint16_t>(4 + script.number(122));
  profile.limits.read[3] = static_cast<std::uint16_t>(4 + script.number(122));
  profile.limits.read[0] = static_cast<std::uint16_t>(1 + script.number(2000));
  profile.limits.write_registers = static_cast<std::uint16_t>(4 + script.number(120));
  profile.limits.write_coils = static_cast<std::uint16_t>(1 + script.number(1968));
  profile.input_as_holding = script.flag();
  std::uint32_t begin = place_of(script);
  for (int groups = script.byte() % 4; groups > 0 && begin < 0xFF00; --groups) {
    const std::uint32_t end = begin + 4 + script.byte() % 64;
    for (const std::uint32_t border : {begin, end}) {
      const auto* cut = profile.values.at(Table::holding_registers, border);
      if (cut != nullptr && cut->first < border) {
        return;
      }
    }
    profile.groups.push_back({Table::holding_registers, static_cast<std::uint16_t>(begin),
                              static_cast<std::uint16_t>(end - begin)});
    begin = end;
  }
}

inline drive::Device read_device(Script& script) {
  drive::Device device;
  read_profile(script, device.profile);
  const std::uint8_t rules = script.byte();
  device.word_order = order_of(script);
  device.split_values = (rules & 1U) != 0;
  device.split_writes = (rules & 2U) != 0;
  device.allow_reconfigure = (rules & 4U) != 0;
  if ((rules & 8U) != 0) {
    device.write_function = static_cast<std::uint8_t>((rules & 16U) != 0 ? 6 : 16);
  }
  device.verify_word_order = (rules & 32U) != 0;
  device.profile.word_order_register = drive::WordOrderRegister{0x400, {5}, {133}};
  return device;
}

inline std::optional<BroadcastForm> form_of(unsigned choice) {
  return choice % 3 == 0   ? std::nullopt
         : choice % 3 == 1 ? std::optional(BroadcastForm{})
                           : std::optional(BroadcastForm{129, 0x80});
}

/// One that hears broadcasts: like the one before it, or another one.
inline drive::Device read_hearer(Script& script, const drive::Device& before) {
  const std::uint8_t rules = script.byte();
  drive::Device device = (rules & 1U) != 0 ? read_device(script) : before;
  device.bus = drive::BusId{(rules >> 1U) & 1U};
  auto& broadcast = device.profile.broadcast;
  broadcast.form = form_of(rules >> 2U);
  if ((rules & 0x10U) != 0) {
    broadcast.most_registers = static_cast<std::uint16_t>(1 + script.byte() % 8);
  }
  if ((rules & 0x20U) != 0) {
    const std::uint16_t first = place_of(script);
    const auto count =
        static_cast<std::uint16_t>(std::min(1 + script.byte() % 32, 0x10000 - first));
    broadcast.allowed = {{script.flag() ? Table::coils : Table::holding_registers, first, count}};
  }
  if ((rules & 0x40U) != 0) {
    device.word_order = order_of(script);
  }
  return device;
}

/// What a route leads to, and the drives themselves.
struct Scene {
  std::deque<drive::Device> devices;  ///< one, or those that hear a broadcast
  routing::ResolvedRoute resolved;
  std::uint8_t unit = kFirstUnit;

  [[nodiscard]] const drive::Device& device() const { return devices.front(); }
  /// Does the client see the values of this drive in the other order?
  [[nodiscard]] bool is_mirrored(const drive::Device& drive) const {
    return resolved.route.word_order && *resolved.route.word_order != drive.word_order &&
           (resolved.device != nullptr || resolved.is_broadcast());
  }
};

/// It overlaps no window before it, and cuts no value; a broadcast is written.
inline bool is_sound(const Scene& scene, const routing::AddressWindow& window) {
  for (const auto& other : scene.resolved.route.windows) {
    if (other.table == window.table && other.from < window.from + window.count &&
        window.from < other.from + other.count) {
      return false;
    }
  }
  for (const drive::Device& device : scene.devices) {
    const bool aliased =
        device.profile.input_as_holding && window.to_table == Table::input_registers;
    const Table table = aliased ? Table::holding_registers : window.to_table;
    for (const drive::Value& value : device.profile.values.all()) {
      for (const std::uint32_t border : {std::uint32_t{window.to}, window.to + window.count}) {
        if (value.table == table && value.first < border && border < value.end()) {
          return false;
        }
      }
    }
  }
  const auto can_write = [](Table table) {
    return table == Table::coils || table == Table::holding_registers;
  };
  return !scene.resolved.is_broadcast() || (can_write(window.table) && can_write(window.to_table));
}

inline void read_windows(Script& script, Scene& scene) {
  for (int windows = script.byte() % 4; windows > 0; --windows) {
    routing::AddressWindow window;
    window.table = static_cast<Table>(script.byte() % 4);
    window.to_table = !script.flag()             ? window.table
                      : holds_bits(window.table) ? Table::discrete_inputs
                                                 : Table::input_registers;
    window.from = place_of(script);
    window.to = place_of(script);
    window.count =
        std::min<std::uint32_t>(1U + script.word(), 0x10000U - std::max(window.from, window.to));
    if (is_sound(scene, window)) {
      scene.resolved.route.windows.push_back(window);
      scene.resolved.route.functions = routing::FunctionRules::rewritable();
    }
  }
}

inline void read_broadcast(Script& script, Scene& scene) {
  for (int more = script.byte() % 4; more > 0; --more) {
    scene.devices.push_back(read_hearer(script, scene.devices.back()));
  }
  const std::uint8_t rules = script.byte();
  scene.devices.front().profile.broadcast.form = form_of(rules >> 2U);
  if ((rules & 1U) != 0) {
    scene.devices.pop_front();
  }
  auto& resolved = scene.resolved;
  resolved.route.broadcast_mixed = true;
  resolved.route.first_unit = resolved.route.last_unit = resolved.route.first_address = 0;
  scene.unit = 0;
  resolved.route.buses = {drive::BusId{0}, drive::BusId{1}};
  if ((rules & 2U) != 0) {
    resolved.only_form = BroadcastForm{129, 0x80};
    resolved.route.buses.pop_back();
  }
  for (const drive::BusId bus : resolved.route.buses) {
    auto& known = resolved.devices_of_buses.emplace_back();
    known.bus = bus;
    for (const drive::Device& device : scene.devices) {
      if (device.bus == bus) {
        known.devices.push_back(&device);
      }
    }
  }
}

inline void read_scene(Script& script, Scene& scene) {
  scene.devices.push_back(read_device(script));
  const std::uint8_t kind = script.byte();
  auto& resolved = scene.resolved;
  resolved.route.first_unit = kFirstUnit;
  resolved.route.last_unit = kLastUnit;
  resolved.route.first_address = kFirstAddress;
  resolved.route.buses = {scene.device().bus};
  scene.unit = static_cast<std::uint8_t>(kFirstUnit + (kind >> 2U) % kLastUnit);
  if ((kind & 2U) != 0) {
    read_broadcast(script, scene);
  } else if ((kind & 1U) != 0) {
    scene.devices.front().address =
        static_cast<std::uint8_t>(kFirstAddress + scene.unit - kFirstUnit);
    resolved.device = &scene.device();
  }
  if ((kind & 3U) != 0 && script.flag()) {
    resolved.route.word_order = order_of(script);
  }
  read_windows(script, scene);
}

}  // namespace mbgate::fuzz
