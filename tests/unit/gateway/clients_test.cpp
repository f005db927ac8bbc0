// SPDX-License-Identifier: Apache-2.0
// Connections: back-pressure, order, half-closed and vanished clients, limits, hostile bytes.
#include <gmock/gmock.h>

#include "support/machine_rig.hpp"

namespace mbgate::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

std::string read_request(unsigned transaction, unsigned unit = 1) {
  char text[64];
  std::snprintf(text, sizeof text, "%04X 0000 0006 %02X 03 0000 0001 ", transaction, unit);
  return text;
}

std::string write_request(unsigned transaction, unsigned unit = 1) {
  char text[64];
  std::snprintf(text, sizeof text, "%04X 0000 0006 %02X 06 0000 0001 ", transaction, unit);
  return text;
}

TEST(Gateway, TakesAtMostThePipelineAndThenReadsAheadAtMostFourKilobytes) {
  MachineRig rig;
  rig.connect(1);
  std::string many;
  for (unsigned transaction = 0; transaction < 100; ++transaction) {
    many += read_request(transaction);
  }
  rig.receive(1, many);  // 1200 bytes
  EXPECT_FALSE(rig.paused.contains(1));
  rig.receive(1, many);
  EXPECT_TRUE(rig.paused.contains(1));
  for (int answers = 0; answers < 16; ++answers) {
    rig.advance(10ms);
    rig.respond("01 03 02 00 01");
  }
  EXPECT_THAT(rig.take_sent(1), SizeIs(16));
  for (int answers = 0; answers < 184; ++answers) {
    rig.advance(10ms);
    rig.respond("01 03 02 00 01");
  }
  EXPECT_THAT(rig.take_sent(1), SizeIs(184));
  EXPECT_FALSE(rig.paused.contains(1));
}

TEST(Gateway, AClientThatNeverReadsIsNotReadFurther) {
  MachineRig rig;
  rig.confirms = false;
  rig.connect(1);
  std::string many;
  for (unsigned transaction = 0; transaction < 200; ++transaction) {
    many += read_request(transaction, 250);  // no route: answered at once with 0A
  }
  rig.receive(1, many);
  EXPECT_THAT(rig.sent[1], SizeIs(16));
  EXPECT_TRUE(rig.paused.contains(1));
  rig.confirm_sent(1);
  EXPECT_THAT(rig.sent[1], SizeIs(17));
}

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

TEST(Gateway, DropsWaitingWritesButAnswersReadsAfterAHalfClose) {
  MachineRig rig;
  rig.connect(1);
  rig.receive(1, read_request(1) + write_request(2) + read_request(3));
  rig.half_close(1);
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 02 00 00 00 03 01 86 06"));
  rig.respond("01 03 02 00 01");
  rig.advance(10ms);
  EXPECT_FALSE(rig.closed.contains(1));
  rig.respond("01 03 02 00 03");
  EXPECT_THAT(rig.take_sent(1),
              ElementsAre("00 01 00 00 00 05 01 03 02 00 01", "00 03 00 00 00 05 01 03 02 00 03"));
  EXPECT_THAT(rig.take_transmitted(), SizeIs(2));
  EXPECT_TRUE(rig.closed.contains(1));
}

TEST(Gateway, AHalfClosedClientIsReadToItsEndBeforeItIsClosed) {
  MachineRig rig;
  rig.connect(1);
  std::string piece;
  for (unsigned transaction = 0; transaction < 170; ++transaction) {
    piece += read_request(transaction, 250);
  }
  rig.confirms = false;
  const std::string first = piece + "00 AA 00 00 00 06 FA 03";  // 2048 bytes: there may be more
  rig.receive(1, first, 2048);
  rig.receive(1, "00 00 00 01" + piece + "00 AA 00 00", 8);
  EXPECT_TRUE(rig.paused.contains(1));
  rig.half_close(1);  // noticed while paused
  rig.confirms = true;
  for (int answers = 0; answers < 16; ++answers) {
    rig.confirm_sent(1);
  }
  EXPECT_FALSE(rig.paused.contains(1));
  EXPECT_FALSE(rig.closed.contains(1));
  rig.receive(1, "00 06 FA 03 00 00 00 01");
  EXPECT_THAT(rig.sent[1], SizeIs(342));
  rig.half_close(1);
  EXPECT_TRUE(rig.closed.contains(1));
}

TEST(Gateway, ADeadlineThatPassedMeans06AndNoTransmission) {
  MachineRig rig;
  rig.connect(1);
  rig.connect(2, "192.0.2.2");
  for (unsigned transaction = 0; transaction < 6; ++transaction) {
    rig.receive(2, read_request(transaction, 9));  // silent: 2 x 107 ms each
  }
  rig.receive(1, write_request(7) + write_request(8) + write_request(9));
  rig.advance(1s);
  // Turns alternate between the two addresses: the third write comes after its second has passed.
  const auto sent = rig.take_sent(1);
  ASSERT_THAT(sent, SizeIs(3));
  EXPECT_EQ(sent.back(), "00 09 00 00 00 03 01 86 06");
}

class PausedClient : public testing::Test {
 protected:
  // Reading is paused from 5 ms on, with one request on the wire and `unread` bytes in the socket;
  // the answer comes 60 ms later, and reading goes on.
  explicit PausedClient() : rig_(settings()) {
    rig_.connect(1);
    std::string many = read_request(0);
    for (unsigned transaction = 1; transaction < 200; ++transaction) {
      many += write_request(transaction, 250);  // no such path: answered at once
    }
    rig_.receive(1, many);
    EXPECT_TRUE(rig_.paused.contains(1));
    rig_.advance(60ms);
    rig_.respond("01 03 02 00 01");
    EXPECT_FALSE(rig_.paused.contains(1));
    rig_.advance(10ms);
    rig_.take_transmitted();
    rig_.take_sent(1);
  }
  static Settings settings() {
    Settings settings = one_bus();
    settings.listeners[0].pipeline = 1;
    settings.routes[0].deadline = 50ms;
    return settings;
  }
  MachineRig rig_;
};

TEST_F(PausedClient, ARequestReadAfterThePauseIsAsOldAsThePause) {
  rig_.receive(1, write_request(999));  // it may have lain in the socket for 70 ms
  rig_.advance(10s);
  EXPECT_THAT(rig_.take_transmitted(), IsEmpty());
  EXPECT_THAT(rig_.take_sent(1), ElementsAre("03 E7 00 00 00 03 01 86 06"));
  rig_.receive(1, write_request(1000));  // this one came just now
  EXPECT_THAT(rig_.take_transmitted(), SizeIs(1));
}

TEST_F(PausedClient, AnEmptySocketAfterThePauseMakesTheNextRequestFresh) {
  rig_.receive(1, "");
  rig_.advance(10min);
  rig_.receive(1, write_request(999));
  EXPECT_THAT(rig_.take_transmitted(), SizeIs(1));
}

TEST_F(PausedClient, WhatCameBehindALaterPauseCountsFromThatPause) {
  // 2040 bytes of 4080: the first 170 requests came during the first pause, 170 more may have come
  // since.
  std::string piece;
  for (unsigned transaction = 0; transaction < 170; ++transaction) {
    piece += read_request(transaction);
  }
  rig_.receive(1, piece, 2040);
  EXPECT_THAT(rig_.take_transmitted(), IsEmpty());  // 70 ms old: too old
  EXPECT_THAT(rig_.take_sent(1), SizeIs(170));
  rig_.receive(1, piece, 0);
  EXPECT_THAT(rig_.take_sent(1), SizeIs(170));  // they lay behind the first ones at the same time
  rig_.receive(1, piece, 0);
  EXPECT_THAT(rig_.take_transmitted(), SizeIs(1));
}

TEST(Gateway, RefusesWritesThatWaitedBeforeTheStart) {
  MachineRig rig;
  rig.connect(1, "192.0.2.1", 0, 24);  // two requests lay in the socket
  rig.receive(1, write_request(1) + read_request(2) + write_request(3));
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 01 00 00 00 03 01 86 06"));
  EXPECT_THAT(rig.take_transmitted(), SizeIs(1));
  rig.respond("01 03 02 00 01");
  rig.advance(10ms);
  EXPECT_THAT(rig.take_transmitted(), ElementsAre("01 06 00 00 00 01 48 0A"));
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

TEST(Gateway, MakesRoomByClosingTheLongestIdleConnection) {
  Settings settings = one_bus();
  settings.listeners[0].max_connections = 3;
  settings.listeners[0].keep = {*routing::Network::parse("192.0.2.1")};
  MachineRig rig(settings);
  rig.connect(1, "192.0.2.1");
  rig.advance(1s);
  rig.connect(2, "192.0.2.2");
  rig.advance(1s);
  rig.connect(3, "192.0.2.3");
  rig.receive(2, read_request(1));  // outstanding work
  rig.connect(4, "192.0.2.4");
  EXPECT_THAT(rig.closed, ElementsAre(3));
  rig.receive(4, read_request(1));
  rig.connect(5, "192.0.2.5");
  EXPECT_THAT(rig.closed, ElementsAre(3, 5));
  EXPECT_THAT(
      rig.events,
      ElementsAre("listener plant: client 192.0.2.3 closed: idle, and its place was needed",
                  "listener plant: client 192.0.2.5 refused: max_connections is reached and "
                  "no connection is idle"));
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

TEST(Gateway, AFullQueueMeans06) {
  Settings settings = one_bus();
  settings.buses[0].queue = 2;
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, read_request(1) + read_request(2) + read_request(3) + read_request(4));
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 04 00 00 00 03 01 83 06"));
}

}  // namespace
}  // namespace mbgate::test
