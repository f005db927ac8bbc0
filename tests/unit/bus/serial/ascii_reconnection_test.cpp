// SPDX-License-Identifier: Apache-2.0
#include "ascii_framer_rig.hpp"

namespace mbgate::test {
namespace {

class AsciiReconnection : public AsciiRig {};

TEST_F(AsciiReconnection, NothingOfBeforeGoesOnOnAnotherConnection) {
  framer_.listen();
  add(":0103021");
  framer_.forget();
  add("234B4\r\n");
  EXPECT_FALSE(framer_.take_unsolicited());
}

}  // namespace
}  // namespace mbgate::test
