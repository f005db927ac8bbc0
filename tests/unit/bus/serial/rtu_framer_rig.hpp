// SPDX-License-Identifier: Apache-2.0
// An RTU framer at 19200 8E1: 573 us a character, t3.5 = 2.005 ms.
#pragma once

#include "bus/serial/rtu_framer.hpp"
#include "framer_rig.hpp"

namespace mbgate::test {

class RtuRig : public FramerRig<bus::RtuFramer> {
 protected:
  RtuRig() : FramerRig(modbus::RtuTiming(modbus::Baud{19200}, {}), 20ms) {}
  Verdict add(std::string_view bytes) { return FramerRig::add(unhex(bytes)); }
};

}  // namespace mbgate::test
