// SPDX-License-Identifier: Apache-2.0
#include "bus/serial/ascii_framer.hpp"
#include "framer_rig.hpp"

namespace mbgate::test {
namespace {

class AsciiReconnection : public FramerRig<bus::AsciiFramer> {
 protected:
  AsciiReconnection()
      : FramerRig(modbus::RtuTiming(modbus::Baud{9600}, {7, modbus::Parity::even, 1}), 20ms) {}
  void add(std::string_view text) {
    FramerRig::add({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  }
};

TEST_F(AsciiReconnection, NothingOfBeforeGoesOnOnAnotherConnection) {
  framer_.listen();
  add(":0103021");
  framer_.forget();
  add("234B4\r\n");
  EXPECT_FALSE(framer_.take_unsolicited());
}

}  // namespace
}  // namespace mbgate::test
