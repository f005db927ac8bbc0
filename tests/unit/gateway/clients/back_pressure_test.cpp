// SPDX-License-Identifier: Apache-2.0
// How far a client is read, how old its requests are, and what a half-close means.
#include <gmock/gmock.h>

#include "support/machine_rig.hpp"

namespace mbgate::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

TEST(Gateway, UnderstandsAtOnceWhatWasReadUpTo64Requests) {
  MachineRig rig;
  rig.connect(1);
  std::string many;
  for (unsigned transaction = 0; transaction < 63; ++transaction) {
    many += read_request(transaction);
  }
  rig.receive(1, many);
  EXPECT_FALSE(rig.paused.contains(1));
  rig.receive(1, many);
  EXPECT_TRUE(rig.paused.contains(1));
  for (int answers = 0; answers < 126; ++answers) {
    rig.advance(40ms);
    rig.respond("01 03 02 00 01");
  }
  EXPECT_THAT(rig.take_sent(1), SizeIs(126));
  EXPECT_FALSE(rig.paused.contains(1));
}

TEST(Gateway, UnderstandsNoMoreThan64RequestsOfWhatWasReadAtOnce) {
  MachineRig rig;
  rig.connect(1);
  std::string many;
  for (unsigned transaction = 0; transaction < 66; ++transaction) {
    many += read_request(transaction);
  }
  rig.receive(1, many);
  EXPECT_EQ(rig.harness.gateway().report_status(0s, rig.now()).listeners[0].counters.requests, 64U);
  rig.advance(40ms);
  rig.respond("01 03 02 00 01");
  EXPECT_EQ(rig.harness.gateway().report_status(0s, rig.now()).listeners[0].counters.requests, 65U);
}

TEST(Gateway, GivesThePipelineToBusesAndTheRestInItsTurn) {
  Settings settings = one_bus();
  settings.listeners[0].pipeline = 2;
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, read_request(1) + read_request(2) + read_request(3) + read_request(4, 250));
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 04 00 00 00 03 FA 83 0A"));
  EXPECT_EQ(rig.harness.gateway().report_status(0s, rig.now()).buses[0].waiting, 1U);
  for (int answers = 0; answers < 3; ++answers) {
    rig.advance(40ms);
    rig.respond("01 03 02 00 01");
  }
  EXPECT_THAT(rig.take_sent(1), SizeIs(3));
}

TEST(Gateway, ARequestBeyondThePipelineGets06AtItsDeadline) {
  Settings settings = one_bus();
  settings.listeners[0].pipeline = 1;
  settings.routes[0].deadline = 50ms;
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, read_request(1) + write_request(2));
  rig.advance(10ms);
  rig.receive(1, read_request(3));
  rig.advance(39ms);
  EXPECT_THAT(rig.take_sent(1), IsEmpty());
  rig.advance(1ms);
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 02 00 00 00 03 01 86 06"));
  rig.advance(10ms);
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 03 00 00 00 03 01 83 06"));
  rig.respond("01 03 02 00 01");
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 01 00 00 00 05 01 03 02 00 01"));
}

TEST(Gateway, AClientThatNeverReadsIsNotReadFurther) {
  MachineRig rig;
  rig.confirms = false;
  rig.connect(1);
  std::string many;
  for (unsigned transaction = 0; transaction < 100; ++transaction) {
    many += read_request(transaction, 250);  // no route: answered at once with 0A
  }
  rig.receive(1, many);
  EXPECT_THAT(rig.sent[1], SizeIs(100));
  EXPECT_TRUE(rig.paused.contains(1));
  for (int answers = 0; answers < 36; ++answers) {
    rig.confirm_sent(1);
  }
  EXPECT_TRUE(rig.paused.contains(1));
  rig.confirm_sent(1);
  EXPECT_FALSE(rig.paused.contains(1));
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
  for (int answers = 0; answers < 341; ++answers) {
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
  rig.receive(1, write_request(5) + write_request(6) + write_request(7) + write_request(8) +
                     write_request(9) + write_request(10));
  rig.advance(1100ms);
  // The first goes after the read on the wire, and each is unanswered for 100 ms and leaves its
  // device alone for as long again: the sixth would come after its 1002.5 ms.
  const auto sent = rig.take_sent(1);
  ASSERT_THAT(sent, SizeIs(6));
  EXPECT_THAT(sent, testing::Contains("00 0A 00 00 00 03 01 86 06"));
  EXPECT_LT(std::ranges::count(rig.take_transmitted(), "01 06 00 00 00 01 48 0A"), 6);
}

class PausedClient : public testing::Test {
 protected:
  // Reading is paused from 5 ms on, with one request on the wire; the answer comes 60 ms later, and
  // reading goes on.
  PausedClient() : rig_(settings()) {
    rig_.connect(1);
    rig_.receive(1, read_request(0));
    rig_.confirms = false;
    std::string many;
    for (unsigned transaction = 1; transaction < 64; ++transaction) {
      many += write_request(transaction, 250);  // no such path: answered at once
    }
    rig_.receive(1, many);
    EXPECT_TRUE(rig_.paused.contains(1));
    rig_.advance(60ms);
    rig_.confirms = true;
    for (int answers = 0; answers < 63; ++answers) {
      rig_.confirm_sent(1);
    }
    rig_.respond("01 03 02 00 01");
    EXPECT_FALSE(rig_.paused.contains(1));
    rig_.advance(10ms);
    rig_.take_transmitted();
    rig_.take_sent(1);
  }
  static Settings settings() {
    Settings settings = one_bus();
    settings.routes[0].deadline = 50ms;
    return settings;
  }
  MachineRig rig_;
};

TEST_F(PausedClient, AWriteReadAfterThePauseIsAsOldAsThePause) {
  rig_.receive(1, write_request(999));  // it may have lain in the socket for 70 ms
  rig_.advance(10s);
  EXPECT_THAT(rig_.take_transmitted(), IsEmpty());
  EXPECT_THAT(rig_.take_sent(1), ElementsAre("03 E7 00 00 00 03 01 86 06"));
  rig_.receive(1, write_request(1000));  // this one came just now
  EXPECT_THAT(rig_.take_transmitted(), SizeIs(1));
}

TEST_F(PausedClient, AReadCountsFromWhenItWasRead) {
  rig_.receive(1, read_request(999));
  EXPECT_THAT(rig_.take_transmitted(), SizeIs(1));
}

TEST_F(PausedClient, AnEmptySocketAfterThePauseMakesTheNextWriteFresh) {
  rig_.receive(1, "");
  rig_.advance(10min);
  rig_.receive(1, write_request(999));
  EXPECT_THAT(rig_.take_transmitted(), SizeIs(1));
}

TEST(Gateway, AReadCountsFromItsLastByte) {
  MachineRig rig;
  rig.connect(1);
  rig.receive(1, "00 01 00 00 00 06 01 03 00");
  rig.advance(9s);  // longer than the deadline of a read
  rig.receive(1, "00 00 01");
  EXPECT_THAT(rig.take_transmitted(), SizeIs(1));
  EXPECT_THAT(rig.take_sent(1), IsEmpty());
}

TEST(Gateway, AWriteThatWaitedToBeAcceptedIsAsOld) {
  MachineRig rig;
  rig.advance(1min);
  rig.connect(1, "192.0.2.1", 0, rig.now() - 1min);
  rig.receive(1, write_request(1));
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 01 00 00 00 03 01 86 06"));
  EXPECT_THAT(rig.take_transmitted(), IsEmpty());
  rig.connect(2, "192.0.2.2", 0, rig.now() - 300ms);
  rig.receive(2, write_request(2));
  EXPECT_THAT(rig.take_transmitted(), SizeIs(1));
}

TEST(Gateway, RefusesWritesThatWaitedBeforeTheStart) {
  MachineRig rig;
  rig.connect(1, "192.0.2.1", 0, Instant::min());  // two requests lay in the socket
  rig.receive(1, write_request(1) + read_request(2));
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 01 00 00 00 03 01 86 06"));
  EXPECT_THAT(rig.take_transmitted(), SizeIs(1));
  rig.receive(1, write_request(3));
  rig.respond("01 03 02 00 01");
  rig.advance(10ms);
  EXPECT_THAT(rig.take_transmitted(), ElementsAre("01 06 00 00 00 01 48 0A"));
}

}  // namespace
}  // namespace mbgate::test
