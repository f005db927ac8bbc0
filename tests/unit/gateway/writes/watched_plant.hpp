// SPDX-License-Identifier: Apache-2.0
// A plant of whose drives the first has failsafe writes.
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
inline constexpr auto kAcknowledged =
    "device axis-x: the client that counts for it has gone; the device has acknowledged its "
    "failsafe writes";
inline constexpr auto kNotYet =
    "device axis-x: the client that counts for it has gone; its failsafe writes are not "
    "acknowledged yet, and are sent again";
inline constexpr auto kBack =
    "device axis-x: the client that counts for it asks again; not all of its failsafe writes were "
    "acknowledged";
inline constexpr Duration kGrace = 1s;  ///< the default

/// A write to unit 1, or another one, that its drive carries out.
inline void write(MachineRig& rig, std::uint64_t client, unsigned unit = 1) {
  rig.receive(client, write_request(98, unit));
  rig.advance(5ms);
  rig.respond(unit == 1 ? kWrite1 : kWrite2);
  rig.advance(10ms);
  rig.take_transmitted();
  rig.take_sent(client);
}

/// A read of unit 2, or another one, answered.
inline void ask(MachineRig& rig, std::uint64_t client, unsigned unit = 2) {
  rig.receive(client, read_request(99, unit));
  rig.advance(5ms);
  rig.respond(unit == 1 ? "01 03 02 00 01" : "02 03 02 00 01");
  rig.advance(10ms);
  rig.take_transmitted();
  rig.take_sent(client);
}

/// Answers what the gateway writes by itself within this time, and says what that was.
inline Lines answer_all(MachineRig& rig, Duration time = 40ms) {
  Lines requests;
  for (const Instant end = rig.now() + time; rig.now() < end;) {
    for (const auto& request : take_requests(rig)) {
      requests.push_back(request);
      rig.respond(request);
    }
    rig.advance(10ms);
  }
  return requests;
}

}  // namespace mbgate::test
