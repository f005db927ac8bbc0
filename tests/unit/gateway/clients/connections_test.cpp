// SPDX-License-Identifier: Apache-2.0
// Buses that are connections to Modbus TCP servers, which close them: what clients and the journal
// see of it.
#include <gmock/gmock.h>

#include "support/machine_rig.hpp"

namespace mbgate::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

class Connections : public testing::Test {
 protected:
  static Settings server() {
    Settings settings = one_bus();
    settings.buses[0].line.framing = bus::Framing::tcp;
    settings.buses[0].line.remote = bus::Endpoint{"drive", 502};
    return settings;
  }
  Connections() : rig(server()) {
    rig.events.clear();
    rig.opened.clear();
    rig.connect(1);
  }
  /// The answer to the oldest frame that was not looked at yet.
  void answer() {
    const auto frames = rig.take_transmitted();
    ASSERT_THAT(frames, SizeIs(1));
    rig.line(frames[0].substr(0, 5) + "0000 0005 01 03 02 1234");
  }

  MachineRig rig;
};

TEST_F(Connections, AServerThatClosesWhatIsIdleGoesUnnoticed) {
  for (unsigned times = 0; times < 3; ++times) {
    rig.receive(1, read_request(times));
    answer();
    EXPECT_THAT(rig.take_sent(1), SizeIs(1));
    rig.advance(1min);
    rig.close_line();
    rig.receive(1, read_request(times + 100));
    EXPECT_THAT(rig.opened, SizeIs(times + 1));
    EXPECT_THAT(rig.take_sent(1), IsEmpty());
    rig.open_line();
    answer();
    EXPECT_THAT(rig.take_sent(1), SizeIs(1));
    EXPECT_EQ(rig.harness.gateway().status().buses_open, 1U);
  }
  EXPECT_THAT(rig.events, IsEmpty());
}

TEST_F(Connections, AWriteThatAClosedConnectionCutsGets0BAndAReadItsAnswer) {
  rig.receive(1, read_request(1));
  answer();
  rig.receive(1, write_request(2));
  rig.close_line();
  rig.receive(1, read_request(3));
  rig.take_transmitted();
  rig.open_line();
  answer();
  rig.receive(1, read_request(4));
  rig.advance(bus::kTimeToClose);
  rig.close_line();
  rig.take_transmitted();
  rig.open_line();
  answer();
  EXPECT_THAT(rig.take_sent(1),
              ElementsAre("00 01 00 00 00 05 01 03 02 12 34", "00 02 00 00 00 03 01 86 0B",
                          "00 03 00 00 00 05 01 03 02 12 34", "00 04 00 00 00 05 01 03 02 12 34"));
}

TEST_F(Connections, AServerThatHasGoneIsReportedWhenItIsMissed) {
  rig.receive(1, read_request(1));
  answer();
  rig.close_line();
  EXPECT_THAT(rig.events, IsEmpty());
  rig.take_sent(1);
  rig.receive(1, write_request(2));
  rig.lose_line();
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 02 00 00 00 03 01 86 0A"));
  EXPECT_THAT(rig.events, ElementsAre("bus line-a is lost; it is being reopened"));
  rig.advance(100ms);
  rig.open_line();
  EXPECT_THAT(rig.events, SizeIs(2));
  EXPECT_EQ(rig.events.back(), "bus line-a is open");
}

TEST_F(Connections, AReplacedOneIsReportedOnceUntilSomethingComes) {
  const auto poll_in_vain = [this] {
    for (unsigned second = 0; second < 31; ++second) {
      rig.receive(1, write_request(second));
      rig.advance(1s);
    }
    if (rig.opened.size() > 0) {
      rig.opened.clear();
      rig.open_line();
    }
  };
  poll_in_vain();
  const auto replaced =
      "bus line-a: requests are sent, but nothing has come back for 30 s; the connection is "
      "replaced";
  EXPECT_THAT(rig.events, ElementsAre(replaced));
  EXPECT_EQ(rig.shut, 1U);
  poll_in_vain();
  EXPECT_EQ(rig.shut, 2U);
  rig.advance(2s);
  rig.take_transmitted();
  rig.receive(1, read_request(99));
  answer();
  rig.advance(1s);
  poll_in_vain();
  EXPECT_EQ(rig.shut, 3U);
  EXPECT_THAT(rig.events, ElementsAre(replaced, replaced));
}

}  // namespace
}  // namespace mbgate::test
