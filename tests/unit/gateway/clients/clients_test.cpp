// SPDX-License-Identifier: Apache-2.0
// Connections: order of answers, vanished clients, limits, hostile bytes.
#include <gmock/gmock.h>

#include "support/machine_rig.hpp"

namespace mbgate::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

TEST(Gateway, SendsEachAnswerAsSoonAsItIsReady) {
  MachineRig rig;
  rig.connect(1);
  rig.receive(1, read_request(1) + read_request(2, 250));
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 02 00 00 00 03 FA 83 0A"));
}

TEST(Gateway, KeepsTheOrderOfAnswersWhereTheListenerAsksForIt) {
  Settings settings = one_bus();
  settings.listeners[0].ordered = true;
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, read_request(1) + read_request(2, 250));
  EXPECT_THAT(rig.take_sent(1), IsEmpty());
  rig.respond("01 03 02 00 01");
  EXPECT_THAT(rig.take_sent(1),
              ElementsAre("00 01 00 00 00 05 01 03 02 00 01", "00 02 00 00 00 03 FA 83 0A"));
}

TEST(Gateway, NeverTransmitsTheWaitingWriteOfADepartedClient) {
  MachineRig rig;
  rig.connect(1);
  rig.connect(2, "192.0.2.2");
  rig.receive(2, read_request(1, 9));
  rig.receive(1, write_request(1));
  rig.disconnect(1);
  rig.respond("09 03 02 00 01");
  rig.advance(10s);
  EXPECT_THAT(rig.take_transmitted(), SizeIs(1));
  EXPECT_THAT(rig.take_sent(1), IsEmpty());
}

TEST(Gateway, DoesNotRepeatAReadForADepartedClient) {
  MachineRig rig;
  rig.connect(1);
  rig.receive(1, read_request(1));
  rig.disconnect(1);
  rig.advance(10s);
  EXPECT_THAT(rig.take_transmitted(), SizeIs(1));
}

TEST(Gateway, SkipsExactlyTheAduOfAnotherProtocol) {
  MachineRig rig;
  rig.connect(1);
  rig.receive(1, "0001 0005 0004 01 AA BB CC" + read_request(2, 250));
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 02 00 00 00 03 FA 83 0A"));
  EXPECT_FALSE(rig.closed.contains(1));
}

TEST(Gateway, ClosesWhereTheFramingIsLostAndNamesTheReason) {
  for (const auto* length : {"0000", "0001", "00FF", "FFFF"}) {
    MachineRig rig;
    rig.connect(1);
    rig.connect(2, "192.0.2.2");
    rig.receive(1, std::string("0001 0000 ") + length + " 01 03 0000 0001");
    EXPECT_TRUE(rig.closed.contains(1)) << length;
    EXPECT_THAT(rig.events, SizeIs(1));
    rig.receive(2, read_request(1));
    rig.respond("01 03 02 00 01");
    EXPECT_THAT(rig.take_sent(2), SizeIs(1));
  }
  MachineRig rig;
  rig.connect(1);
  rig.receive(1, "0001 0000 FFFF 01 03");
  EXPECT_THAT(rig.events, ElementsAre("listener plant: client 192.0.2.1 closed: MBAP length 65535 "
                                      "is not 2 to 254"));
}

TEST(Gateway, SaysThatAClientSendsRtuToTheTcpPort) {
  MachineRig rig;
  rig.connect(1);
  rig.receive(1, "01 03 00 1E 00 02 A4 0D");
  EXPECT_THAT(
      rig.events,
      ElementsAre("listener plant: client 192.0.2.1 sends RTU frames to the Modbus TCP port; "
                  "it must be set to Modbus TCP"));
}

TEST(Gateway, ClosesAClientWhosePartialAduGetsTooOld) {
  MachineRig rig;
  rig.connect(1);
  rig.receive(1, "0001 0000");
  rig.advance(9s);
  rig.receive(1, "0006");
  EXPECT_FALSE(rig.closed.contains(1));
  rig.advance(1s);
  EXPECT_TRUE(rig.closed.contains(1));
  EXPECT_THAT(rig.events,
              ElementsAre("listener plant: client 192.0.2.1 closed: a request stayed incomplete"));
}

TEST(Gateway, EachPartialAduHasItsOwnFrameTimeout) {
  MachineRig rig;
  rig.connect(1);
  rig.receive(1, "0001 0000");
  rig.advance(1s);
  rig.receive(1, "0006 FA 03 0000 0001");  // whole, and answered at once
  rig.advance(4s);
  rig.receive(1, "0002 0000");
  rig.advance(9s);
  EXPECT_FALSE(rig.closed.contains(1));
  rig.advance(1s);
  EXPECT_TRUE(rig.closed.contains(1));
}

/// Each piece ends within the next request, and never is there none of one.
TEST(Gateway, APartialAduThatIsCompletedTakesNoTimeFromTheNext) {
  MachineRig rig;
  rig.connect(1);
  rig.receive(1, "0001 0000");
  for (int times = 0; times < 10; ++times) {
    rig.advance(3s);
    rig.receive(1, "0006 FA 03 0000 0001 0001 0000");
  }
  EXPECT_FALSE(rig.closed.contains(1));
}

TEST(Gateway, AClientThatWaitsForAnAnswerIsNotIdle) {
  Settings settings = one_bus();
  settings.listeners[0].idle_timeout = 50ms;
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, read_request(1));
  rig.advance(90ms);
  EXPECT_FALSE(rig.closed.contains(1));
  rig.respond("01 03 02 00 01");
  rig.advance(49ms);
  EXPECT_FALSE(rig.closed.contains(1));
  rig.advance(1ms);
  EXPECT_TRUE(rig.closed.contains(1));
}

TEST(Gateway, ClosesIdleClientsAfterTheIdleTimeout) {
  Settings settings = one_bus();
  settings.listeners[0].idle_timeout = 60s;
  MachineRig rig(settings);
  rig.connect(1);
  rig.advance(50s);
  rig.receive(1, read_request(1, 250));
  rig.advance(50s);
  EXPECT_FALSE(rig.closed.contains(1));
  rig.advance(10s);
  EXPECT_TRUE(rig.closed.contains(1));
}

TEST(Gateway, AClientWhoseRequestsGetNoAnswerIsNotIdle) {
  Settings settings = one_bus();
  settings.listeners[0].idle_timeout = 60s;
  MachineRig rig(settings);
  rig.connect(1);
  rig.advance(50s);
  rig.receive(1, "0001 0001 0006 01 03 0000 0001");  // of another protocol
  rig.advance(50s);
  EXPECT_FALSE(rig.closed.contains(1));
}

TEST(Gateway, RefusesClientsThatAreNotInTheAllowList) {
  Settings settings = one_bus();
  settings.listeners[0].allow = {*routing::Network::parse("10.0.0.0/8")};
  MachineRig rig(settings);
  rig.connect(1);
  EXPECT_TRUE(rig.closed.contains(1));
  EXPECT_THAT(rig.events,
              ElementsAre("listener plant: client 192.0.2.1 refused: not in the allow list"));
}

TEST(Gateway, ServesClientAddressesInTurnWhateverTheNumberOfTheirConnections) {
  MachineRig rig;
  rig.connect(1, "192.0.2.1");
  rig.connect(2, "192.0.2.1");
  rig.connect(3, "192.0.2.3");
  rig.receive(1, read_request(1, 11));  // goes at once: nobody else is there yet
  rig.receive(1, read_request(2, 12) + read_request(3, 13));
  rig.receive(2, read_request(1, 21));
  rig.receive(3, read_request(1, 31) + read_request(2, 32));
  std::vector<std::string> units;
  for (int turn = 0; turn < 6; ++turn) {
    rig.advance(10ms);
    const auto frames = rig.take_transmitted();
    ASSERT_THAT(frames, SizeIs(1));
    units.push_back(frames[0].substr(0, 2));
    rig.respond(units.back() + " 03 02 00 01");
  }
  EXPECT_THAT(units, ElementsAre("0B", "0C", "1F", "0D", "20", "15"));
}

// Without TLS a client has no role that could be judged, and what it says can be read by everybody.
TEST(Gateway, ClosesClientsOfAListenerThatHasTlsNow) {
  MachineRig rig;
  rig.connect(1);
  Settings changed = one_bus();
  changed.tls.push_back({"plant"});
  changed.listeners[0].tls = 0;
  rig.reload(changed);
  EXPECT_THAT(rig.closed, ElementsAre(1));
}

TEST(Gateway, AFullQueueMeans06ForTheNewestReadOfWhoHasTheMostWaiting) {
  Settings settings = one_bus();
  settings.buses[0].queue = 2;
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, read_request(1));
  rig.receive(1, read_request(2) + read_request(3) + read_request(4));
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 03 00 00 00 03 01 83 06"));
}

}  // namespace
}  // namespace mbgate::test
