// SPDX-License-Identifier: Apache-2.0
// A plant of whose drives the first is written to when nobody is left who might.
#pragma once

#include "unit/gateway/writes/stop_plant.hpp"

namespace mbgate::test {

inline modbus::Request write_of(std::string_view pdu) {
  return *modbus::Request::parse(*modbus::Pdu::from(unhex(pdu)));
}

/// Device 1: first a stop, then something that is none. Clients of the second listener may only
/// read.
inline Settings watched_plant() {
  Settings settings = stop_plant();
  settings.guards.resize(1);
  settings.guards[0].failsafe = {write_of("06 007C 00E1"), write_of("06 0010 0007")};
  settings.listeners.push_back(settings.listeners[0]);
  settings.listeners[1].name = "screens";
  settings.listeners[1].read_only = {*routing::Network::parse("192.0.2.0/24")};
  return settings;
}

inline constexpr auto kSecond = "01 06 00 10 00 07";
inline constexpr auto kLost = "bus line-a is lost; it is being reopened";

/// A read of unit 2, answered.
inline void ask(MachineRig& rig, std::uint64_t client) {
  rig.receive(client, read_request(99, 2));
  rig.respond("02 03 02 00 01");
  rig.advance(10ms);
  rig.take_transmitted();
  rig.take_sent(client);
}

}  // namespace mbgate::test
