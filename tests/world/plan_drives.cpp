// SPDX-License-Identifier: Apache-2.0
// Profiles and guards of devices; the manners of clients.
#include <array>

#include "world/plan.hpp"

namespace mbgate::world {

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
  device.word_order = random.one_of({drive::WordOrder::big, drive::WordOrder::little});
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

void draw_clients(Plan& plan, Random& random) {
  const unsigned hosts = random.between(1U, kMostHosts);
  const bool is_calm = random.chance(800);
  const unsigned odd = random.one_of({0U, 5U, 20U});
  const auto some = [&](unsigned most) {
    return random.chance(500) ? 0U : static_cast<unsigned>(random.below(most + 1));
  };
  for (unsigned count = random.one_of({2U, 4U, 8U, 16U}); count > 0; --count) {
    Manners manners;
    manners.listener = random.below(plan.settings.listeners.size());
    manners.host = static_cast<unsigned>(random.below(hosts));
    manners.burst = is_calm ? random.between(1U, 2U) : random.one_of({1U, 4U, 12U});
    manners.outstanding = is_calm ? random.between(1U, 4U) : random.one_of({1U, 8U, 20U});
    manners.pause = is_calm ? random.one_of<Duration>({20ms, 50ms, 200ms, 1s})
                            : random.one_of<Duration>({1ms, 20ms, 200ms});
    manners.writes = random.one_of({0U, 100U, 300U, 800U});
    manners.stops = random.one_of({0U, 0U, 20U, 100U});
    manners.broadcasts = random.one_of({0U, 0U, 10U, 50U});
    manners.malformed = some(odd);
    manners.same_reads = random.one_of({0U, 300U, 900U});
    manners.splits = some(200);
    manners.foreign = some(odd);
    manners.vanishes = some(odd);
    manners.half_closes = some(odd / 2);
    manners.stalls = some(odd);
    if (random.chance(200)) {
      manners.patience = random.duration(50ms, 2s);
      manners.repeats = random.chance(500);
    }
    const auto& listener = plan.settings.listeners[manners.listener];
    if (listener.one_at_a_time && manners.patience == Duration{0}) {
      manners.patience = 1s;
    }
    plan.clients.push_back(manners);
  }
}

}  // namespace mbgate::world
