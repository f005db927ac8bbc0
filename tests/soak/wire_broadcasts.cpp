// SPDX-License-Identifier: Apache-2.0
// What is said to all.
#include <vector>

#include "soak/serial_wire.hpp"

namespace mbgate::soak {

// Each device hears the form of its kind.
void SerialWire::carry_out_all(const Flight& flight) {
  const bool is_for_autonics = flight.address != 0;
  std::vector<std::uint8_t> pdu = flight.pdu;
  pdu[0] = static_cast<std::uint8_t>(is_for_autonics ? pdu[0] & 0x7FU : pdu[0]);
  for (SoakDevice* device : devices_) {
    const bool listens = is_for_autonics == (device->settings().profile.broadcast.form ==
                                             drive::BroadcastForm::autonics);
    if (listens && !device->is_dead(around_.schedule.now())) {
      device->carry_out(*modbus::Pdu::from(pdu), around_.schedule.now());
    }
  }
}

}  // namespace mbgate::soak
