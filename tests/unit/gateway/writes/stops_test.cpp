// SPDX-License-Identifier: Apache-2.0
// Stops overtake what their clients sent before, and are carried out whatever becomes of these.
#include <gmock/gmock.h>

#include "unit/gateway/writes/stop_plant.hpp"

namespace mbgate::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// Transaction 1, a read, is on the wire; the pipeline is full.
class Stops : public testing::Test {
 protected:
  explicit Stops(Settings settings = stop_plant()) : rig_(std::move(settings)) {
    rig_.connect(1);
    rig_.receive(1, read_request(1));
    EXPECT_THAT(take_requests(rig_), ElementsAre(kRead1));
  }
  void answer_read() {
    rig_.respond("01 03 02 00 01");
    rig_.advance(10ms);
  }
  /// Answers a write as it was asked.
  void echo(const std::string& request) {
    rig_.respond(request);
    rig_.advance(10ms);
  }
  MachineRig rig_;
};

TEST_F(Stops, AreTakenFromBehindAFullPipeline) {
  rig_.receive(1, read_request(2) + stop_request(3) + read_request(4));
  answer_read();
  EXPECT_THAT(take_requests(rig_), ElementsAre(kStop1));
  echo(kStop1);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(kOne, written(3, 1, true)));
  EXPECT_THAT(take_requests(rig_), ElementsAre(kRead1));
  answer_read();
  answer_read();
  EXPECT_THAT(rig_.take_sent(1),
              ElementsAre("00 02 00 00 00 05 01 03 02 00 01", "00 04 00 00 00 05 01 03 02 00 01"));
}

TEST_F(Stops, AreTakenOnceTheyAreWhole) {
  rig_.receive(1, read_request(2) + "0003 0000 0006 01 06 00");
  rig_.receive(1, "7C 00");
  answer_read();
  EXPECT_THAT(take_requests(rig_), ElementsAre(kRead1));
  rig_.receive(1, "E1");
  answer_read();
  EXPECT_THAT(take_requests(rig_), ElementsAre(kStop1));
}

TEST_F(Stops, OvertakenWritesToTheirDeviceAreNeverTransmitted) {
  rig_.receive(1, write_request(2, 1) + write_request(3, 2) + stop_request(4) + write_request(5));
  answer_read();
  EXPECT_THAT(take_requests(rig_), ElementsAre(kStop1));
  echo(kStop1);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(kOne, written(4, 1, true), busy(2)));
  EXPECT_THAT(take_requests(rig_), ElementsAre(kWrite2));
  echo(kWrite2);
  // What its client sent behind it is meant.
  EXPECT_THAT(take_requests(rig_), ElementsAre(kWrite1));
}

TEST_F(Stops, TakeBackWhatOtherClientsSentBefore) {
  rig_.connect(2, "192.0.2.2");
  rig_.receive(2, read_request(10) + write_request(11, 1) + write_request(12, 2));
  rig_.advance(1ms);
  rig_.receive(1, stop_request(2));
  rig_.receive(2, write_request(13, 1));  // not before it
  answer_read();
  echo(kStop1);
  answer_read();
  EXPECT_THAT(take_requests(rig_), ElementsAre(kStop1, kRead1, kWrite2));
  echo(kWrite2);
  EXPECT_THAT(take_requests(rig_), ElementsAre(kWrite1));
  EXPECT_THAT(rig_.take_sent(2),
              ElementsAre("00 0A 00 00 00 05 01 03 02 00 01", busy(11), written(12, 2)));
}

TEST_F(Stops, GoThoughTheirClientHasGone) {
  rig_.receive(1, read_request(2) + write_request(3) + stop_request(4));
  rig_.disconnect(1);
  answer_read();
  EXPECT_THAT(take_requests(rig_), ElementsAre(kStop1));
  echo(kStop1);
  EXPECT_THAT(take_requests(rig_), IsEmpty());
  EXPECT_THAT(rig_.take_sent(1), IsEmpty());
}

TEST_F(Stops, ThatWereReceivedWholeAllGoWhenTheirClientLeaves) {
  std::string many = read_request(2);
  for (unsigned transaction = 3; transaction < 20; ++transaction) {
    many += stop_request(transaction);
  }
  rig_.receive(1, many + stop_request(20, 2));  // behind more than the reserve
  rig_.disconnect(1);
  EXPECT_THAT(rig_.take_sent(1), IsEmpty());
  answer_read();
  Lines requests;
  for (int turn = 0; turn < 20; ++turn) {
    for (const auto& request : take_requests(rig_)) {
      requests.push_back(request);
      echo(request);
    }
  }
  EXPECT_THAT(requests, testing::Contains(kStop2));
}

TEST_F(Stops, AreCarriedOutAndAnsweredAfterAHalfClose) {
  rig_.receive(1, write_request(2) + stop_request(3));
  rig_.half_close(1);
  answer_read();
  EXPECT_THAT(take_requests(rig_), ElementsAre(kStop1));
  echo(kStop1);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(busy(2), kOne, written(3, 1, true)));
  EXPECT_TRUE(rig_.closed.contains(1));
}

TEST_F(Stops, AreCarriedOutWhenTheGatewayStops) {
  rig_.receive(1, write_request(2) + stop_request(3));
  rig_.shutdown();
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(busy(2)));
  rig_.receive(1, stop_request(4, 2));
  answer_read();
  echo(kStop1);
  EXPECT_FALSE(rig_.finished);
  echo(kStop2);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(kOne, written(3, 1, true), written(4, 2, true)));
  EXPECT_TRUE(rig_.finished);
  rig_.receive(1, stop_request(5));
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(busy(5)));
}

class OrderedStops : public Stops {
 protected:
  OrderedStops() : Stops(settings()) {}
  static Settings settings() {
    Settings settings = stop_plant();
    settings.listeners[0].ordered = true;
    return settings;
  }
};

TEST_F(OrderedStops, AreAnsweredInTheirPlace) {
  rig_.receive(1, read_request(2) + write_request(3) + stop_request(4) + read_request(5));
  answer_read();
  EXPECT_THAT(take_requests(rig_), ElementsAre(kStop1));
  echo(kStop1);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(kOne));
  answer_read();
  EXPECT_THAT(rig_.take_sent(1),
              ElementsAre("00 02 00 00 00 05 01 03 02 00 01", busy(3), written(4, 1, true)));
  answer_read();
  EXPECT_THAT(rig_.take_sent(1), ElementsAre("00 05 00 00 00 05 01 03 02 00 01"));
}

TEST_F(OrderedStops, AreAnsweredInTheirPlaceIfThatComesFirst) {
  rig_.receive(1, write_request(2) + stop_request(3));
  answer_read();
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(kOne));
  echo(kStop1);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(busy(2), written(3, 1, true)));
}

}  // namespace
}  // namespace mbgate::test
