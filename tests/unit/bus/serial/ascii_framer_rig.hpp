// SPDX-License-Identifier: Apache-2.0
// An ASCII framer at 9600 7E1.
#pragma once

#include "bus/serial/ascii_framer.hpp"
#include "framer_rig.hpp"

namespace mbgate::test {

class AsciiRig : public FramerRig<bus::AsciiFramer> {
 protected:
  AsciiRig()
      : FramerRig(modbus::RtuTiming(modbus::Baud{9600}, {7, modbus::Parity::even, 1}), 20ms) {}
  Verdict add(std::string_view text) {
    return FramerRig::add({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  }
};

}  // namespace mbgate::test
