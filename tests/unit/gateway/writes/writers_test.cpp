// SPDX-License-Identifier: Apache-2.0
// Who may write to a device that has a rule for it.
#include <gmock/gmock.h>

#include "unit/gateway/writes/stop_plant.hpp"

namespace mbgate::test {
namespace {

using gateway::WriterRule;
using testing::ElementsAre;
using testing::IsEmpty;

Settings guarded(WriterRule rule) {
  Settings settings = stop_plant(16);
  settings.guards.resize(1);
  settings.guards[0].writer = rule;
  settings.guards[0].writers = {*routing::Network::parse("192.0.2.1")};
  settings.routes.emplace_back().buses = {BusId{0}};  // unit 0
  return settings;
}

class FirstWriter : public testing::Test {
 protected:
  FirstWriter() {
    rig_.connect(1, "192.0.2.1");
    rig_.connect(2, "192.0.2.2");
    rig_.receive(1, write_request(1));
    rig_.respond(kWrite1);
    rig_.advance(10ms);
    rig_.take_transmitted();
  }
  MachineRig rig_{guarded(WriterRule::first)};
};

// It is the same drive, and what waits for it goes on.
TEST_F(FirstWriter, OwnsItUnderAnotherNameToo) {
  rig_.receive(1, write_request(2) + read_request(3));
  Settings renamed = guarded(WriterRule::first);
  renamed.devices[0].name = "another";
  rig_.reload(renamed);
  rig_.receive(2, write_request(4));
  EXPECT_THAT(rig_.take_sent(2), ElementsAre(busy(4)));
  rig_.respond(kWrite1);
  rig_.advance(10ms);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(written(1), written(2)));
  EXPECT_THAT(rig_.take_transmitted(), testing::SizeIs(2));
}

TEST_F(FirstWriter, OwnsWritingForAWhile) {
  rig_.receive(2, write_request(2));
  EXPECT_THAT(rig_.take_sent(2), ElementsAre(busy(2)));
  EXPECT_THAT(rig_.take_transmitted(), IsEmpty());
  rig_.advance(5s);
  rig_.receive(2, write_request(3));
  EXPECT_THAT(take_requests(rig_), ElementsAre(kWrite1));
  rig_.receive(1, write_request(4));
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(written(1), busy(4)));
}

TEST_F(FirstWriter, IsAnAddressAndNoConnection) {
  rig_.disconnect(1);
  rig_.connect(3, "192.0.2.1");
  rig_.receive(3, write_request(2));
  EXPECT_THAT(take_requests(rig_), ElementsAre(kWrite1));
}

TEST_F(FirstWriter, DoesNotKeepOthersFromReadingOrFromOtherDevices) {
  rig_.receive(2, read_request(2));
  rig_.respond("01 03 02 00 01");
  rig_.advance(10ms);
  rig_.receive(2, write_request(3, 2));
  EXPECT_THAT(take_requests(rig_), ElementsAre(kRead1, kWrite2));
}

TEST_F(FirstWriter, DoesNotKeepOthersFromStoppingAndAStopTakesNothingOver) {
  rig_.receive(2, stop_request(2));
  rig_.respond(kStop1);
  rig_.advance(10ms);
  EXPECT_THAT(take_requests(rig_), ElementsAre(kStop1));
  rig_.receive(2, write_request(3));
  EXPECT_THAT(rig_.take_sent(2), ElementsAre(written(2, 1, true), busy(3)));
}

TEST_F(FirstWriter, OwnsBroadcastsOfTheBusToo) {
  rig_.receive(2, write_request(2, 0));
  EXPECT_THAT(rig_.take_sent(2), ElementsAre(busy(2, 0)));
  rig_.advance(5s);
  rig_.receive(2, write_request(3, 0));
  rig_.advance(200ms);
  EXPECT_THAT(take_requests(rig_), ElementsAre("00 06 00 00 00 01"));
  rig_.receive(1, write_request(4));
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(written(1), busy(4)));
}

TEST(ListedWriters, AreTheOnlyOnesButForStops) {
  MachineRig rig(guarded(WriterRule::listed));
  rig.connect(1, "192.0.2.1");
  rig.connect(2, "192.0.2.2");
  rig.receive(2, write_request(1) + write_request(2, 0) + stop_request(3));
  rig.respond(kStop1);
  EXPECT_THAT(rig.take_sent(2), ElementsAre("00 01 00 00 00 03 01 86 01",
                                            "00 02 00 00 00 03 00 86 01", written(3, 1, true)));
  rig.receive(1, write_request(4));
  rig.advance(10ms);
  EXPECT_THAT(take_requests(rig), ElementsAre(kStop1, kWrite1));
}

}  // namespace
}  // namespace mbgate::test
