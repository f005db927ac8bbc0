// SPDX-License-Identifier: Apache-2.0
// Profiles and guards of devices.
#include <array>

#include "world/plan_parts.hpp"

namespace mbgate::world {

using namespace std::chrono_literals;
using drive::WordOrder;

namespace {

void add_registers(drive::Profile& profile) {
  const auto place = [](unsigned address) { return static_cast<std::uint16_t>(address); };
  for (unsigned at = 0; at < kRegisters; ++at) {
    if (value_size(at) > 1 && !cuts_value(at)) {
      profile.values.add({Table::holding_registers, place(at),
                          static_cast<std::uint8_t>(value_size(at)), is_motion(at)});
    }
  }
  for (unsigned at = kGroupsFrom; at < kGroupsEnd; at += kGroup) {
    profile.groups.push_back({Table::holding_registers, place(at), kGroup});
  }
  profile.communication.push_back({Table::holding_registers, kCommunicationRegister, 1});
  profile.word_order_register = {kOrderRegister, {kBigOrder}, {kLittleOrder}};
  profile.stops.push_back({Table::holding_registers, kStopRegister, 0xF000, 0x5000});
  profile.stops.push_back({Table::holding_registers, kOtherStop, 0xF000, 0x4000});
  profile.stops.push_back({Table::coils, place(kStopCoil), 0xFFFF, 0xFF00});
}

}  // namespace

void draw_profile(drive::Device& device, bool is_tcp, Random& random) {
  drive::Profile& profile = device.profile;
  add_registers(profile);
  profile.unanswered.push_back(
      {{Table::holding_registers, kSilentRegister, 0xF000, 0x7000}, random.duration(10ms, 200ms)});
  profile.slow.push_back({{Table::holding_registers, kSlowFrom, kSlowEnd - kSlowFrom},
                          2 * device.timing.response_timeout});
  if (random.chance(500)) {
    const auto most = random.between<std::uint16_t>(4, 64);
    profile.limits.read = {2000, 2000, most, most};
    profile.limits.write_registers = random.between<std::uint16_t>(4, 8);
  }
  if (random.chance(200)) {
    profile.functions.reset(random.one_of<std::size_t>({0x07, 0x08, 0x11, 0x16, 0x17, 0x18}));
  }
  if (!is_tcp && random.chance(100)) {
    profile.broadcast.form = std::nullopt;
  }
  device.word_order = random.one_of({WordOrder::big, WordOrder::little});
  device.split_writes = random.chance(500);
  device.cache = random.chance(200) ? random.duration(5ms, 200ms) : 0ms;
  if (random.chance(300)) {
    device.write_function = random.one_of<std::uint8_t>({6, 16});
  }
  device.split_values = random.chance(300);
  device.allow_reconfigure = random.chance(300);
  device.verify_word_order = random.chance(150);
  device.limits_values = random.chance(200);
}

void draw_guards(Plan& plan, Random& random) {
  plan.settings.guards.resize(plan.settings.devices.size());
  for (std::size_t at = 0; at < plan.settings.devices.size(); ++at) {
    gateway::DeviceGuard& guard = plan.settings.guards[at];
    if (random.chance(150)) {
      guard.writer = gateway::WriterRule::first;
      guard.writer_hold = random.duration(100ms, 5s);
    }
    if (!random.chance(250)) {
      continue;
    }
    const std::array<std::uint8_t, 5> write{6, 0, low(kFailsafeRegister), high(kFailsafeWord),
                                            low(kFailsafeWord)};
    guard.failsafe.push_back(*modbus::Request::parse(*modbus::Pdu::from(write)));
    guard.quiet = random.chance(300) ? random.duration(1s, 5s) : 0ms;
    if (random.chance(500)) {
      guard.failsafe_grace = random.duration(100ms, 2s);
    }
  }
}

}  // namespace mbgate::world
