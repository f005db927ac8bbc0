// SPDX-License-Identifier: Apache-2.0
// What is written to a device when the last client that may write has gone.
#include <gmock/gmock.h>

#include "unit/gateway/writes/watched_plant.hpp"

namespace mbgate::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr auto kSent =
    "device axis-x: the last client that may write has gone; its failsafe writes are sent";
constexpr auto kNotYet =
    "device axis-x: the last client that may write has gone; its failsafe writes could not be sent "
    "yet";
constexpr auto kBack =
    "device axis-x: a client that may write asks again; its failsafe writes were not all sent";

class FailsafeWrites : public testing::Test {
 protected:
  /// Connects a client that asks something of unit 2.
  void come(std::uint64_t client, const std::string& address = "192.0.2.1") {
    rig_.connect(client, address);
    ask(rig_, client);
  }
  /// Answers what the gateway writes by itself.
  Lines answer_all() {
    Lines requests;
    for (int turn = 0; turn < 4; ++turn) {
      for (const auto& request : take_requests(rig_)) {
        requests.push_back(request);
        rig_.respond(request);
      }
      rig_.advance(10ms);
    }
    return requests;
  }
  MachineRig rig_{watched_plant()};
};

TEST_F(FailsafeWrites, AreSentInOrderWhenTheLastWriterHasGone) {
  come(1);
  come(2);
  rig_.connect(3, "192.0.2.3", 1);  // may not write
  ask(rig_, 3);
  rig_.disconnect(1);
  EXPECT_THAT(answer_all(), IsEmpty());
  rig_.half_close(2);
  EXPECT_THAT(answer_all(), ElementsAre(kStop1, kSecond));  // it had nothing left, and was closed
  EXPECT_THAT(rig_.events, ElementsAre(kSent));
  rig_.disconnect(3);
  EXPECT_THAT(answer_all(), IsEmpty());
}

TEST_F(FailsafeWrites, AreNotSetOffNorKeptBackByAConnectionThatNeverAskedAnything) {
  rig_.connect(1);
  rig_.disconnect(1);
  EXPECT_THAT(answer_all(), IsEmpty());
  come(2);
  rig_.connect(3);
  rig_.disconnect(2);
  EXPECT_THAT(answer_all(), ElementsAre(kStop1, kSecond));
  rig_.disconnect(3);
  rig_.connect(4);
  rig_.receive(4, "0001 0005 0004 01 AA BB CC");  // another protocol
  rig_.disconnect(4);
  EXPECT_THAT(answer_all(), IsEmpty());
}

TEST_F(FailsafeWrites, AreNotSentWhenTheGatewayStops) {
  come(1);
  rig_.shutdown();
  rig_.disconnect(1);
  EXPECT_THAT(answer_all(), IsEmpty());
  EXPECT_TRUE(rig_.finished);
}

TEST_F(FailsafeWrites, AreEndedBeforeTheGatewayIs) {
  come(1);
  rig_.disconnect(1);
  rig_.shutdown();
  EXPECT_FALSE(rig_.finished);
  EXPECT_THAT(answer_all(), ElementsAre(kStop1, kSecond));
  EXPECT_TRUE(rig_.finished);
}

TEST_F(FailsafeWrites, StayDueUntilTheLineIsBack) {
  come(1);
  rig_.lose_line();
  rig_.disconnect(1);
  rig_.advance(1min);
  EXPECT_THAT(rig_.events, ElementsAre(kLost, kNotYet));
  EXPECT_THAT(rig_.take_transmitted(), IsEmpty());
  rig_.open_line();
  EXPECT_THAT(answer_all(), ElementsAre(kStop1, kSecond));
  EXPECT_THAT(rig_.events, ElementsAre(kLost, kNotYet, "bus line-a is open", kSent));
  rig_.lose_line();
  rig_.open_line();
  EXPECT_THAT(answer_all(), IsEmpty());
}

TEST_F(FailsafeWrites, StayDueOneByOne) {
  come(1);
  rig_.disconnect(1);
  EXPECT_THAT(take_requests(rig_), ElementsAre(kStop1));
  rig_.lose_line();  // the second one is behind it
  EXPECT_THAT(rig_.events, ElementsAre(kLost, kNotYet));
  rig_.open_line();
  EXPECT_THAT(answer_all(), ElementsAre(kSecond));
  EXPECT_THAT(rig_.events, ElementsAre(kLost, kNotYet, "bus line-a is open", kSent));
}

TEST_F(FailsafeWrites, AreNotDueAnyMoreWhenAWriterAsksAgain) {
  come(1);
  rig_.lose_line();
  rig_.disconnect(1);
  rig_.connect(2);  // is no reason yet
  rig_.connect(3, "192.0.2.3", 1);
  rig_.receive(3, read_request(1, 2));  // may not write
  EXPECT_THAT(rig_.events, ElementsAre(kLost, kNotYet));
  rig_.receive(2, read_request(1, 2));
  EXPECT_THAT(rig_.events, ElementsAre(kLost, kNotYet, kBack));
  rig_.open_line();
  EXPECT_THAT(answer_all(), IsEmpty());
  rig_.disconnect(2);
  EXPECT_THAT(answer_all(), ElementsAre(kStop1, kSecond));
}

/// A client has used up the second of its address.
class HeldUpWriter : public testing::Test {
 protected:
  HeldUpWriter() {
    rig_.connect(1);
    ask(rig_, 1);
  }
  static Settings settings() {
    Settings settings = watched_plant();
    settings.listeners[0].max_requests_per_second = 1;
    return settings;
  }
  MachineRig rig_{settings()};
};

TEST_F(HeldUpWriter, HasAskedThoughItsRequestWaitsForItsTurn) {
  rig_.lose_line();
  rig_.disconnect(1);
  rig_.connect(2);
  EXPECT_THAT(rig_.events, ElementsAre(kLost, kNotYet));
  rig_.receive(2, read_request(1, 2));
  EXPECT_THAT(rig_.events, testing::Contains(kBack));
  rig_.open_line();
  rig_.advance(100ms);
  EXPECT_THAT(take_requests(rig_), IsEmpty());
}

TEST_F(HeldUpWriter, IsThereStillAfterAReload) {
  rig_.connect(2);
  rig_.receive(2, read_request(1, 2));
  rig_.disconnect(1);
  rig_.reload(settings());
  EXPECT_THAT(take_requests(rig_), IsEmpty());
}

TEST_F(FailsafeWrites, StayDueWhileOtherSettingsComeAndTheLineIsReplaced) {
  come(1);
  rig_.lose_line();
  rig_.disconnect(1);
  Settings changed = watched_plant();
  std::swap(changed.devices[0], changed.devices[1]);
  changed.guards.insert(changed.guards.begin(), gateway::DeviceGuard());
  rig_.reload(changed);
  changed.buses[0].line.baud = modbus::Baud{9600};
  rig_.reload(changed);
  EXPECT_THAT(answer_all(), IsEmpty());
  rig_.open_line();
  EXPECT_THAT(answer_all(), ElementsAre(kStop1, kSecond));
  EXPECT_THAT(rig_.events, ElementsAre(kLost, kNotYet, "bus line-a is open", kSent));
}

TEST_F(FailsafeWrites, GoOnWhenTheirLineIsReplacedUnderThem) {
  come(1);
  rig_.disconnect(1);
  EXPECT_THAT(take_requests(rig_), ElementsAre(kStop1));
  Settings changed = watched_plant();
  std::swap(changed.devices[0], changed.devices[1]);
  changed.guards.insert(changed.guards.begin(), gateway::DeviceGuard());
  changed.buses[0].line.baud = modbus::Baud{9600};
  rig_.reload(changed);
  rig_.open_line();
  EXPECT_THAT(answer_all(), ElementsAre(kSecond));
}

/// The first of the old ones is on the wire, and the line is lost.
TEST_F(FailsafeWrites, ThatAReloadHasChangedAreAllDueIfNotAllOfTheOldOnesWereSent) {
  come(1);
  rig_.disconnect(1);
  EXPECT_THAT(take_requests(rig_), ElementsAre(kStop1));
  Settings changed = watched_plant();
  std::ranges::reverse(changed.guards[0].failsafe);
  rig_.reload(changed);
  rig_.lose_line();
  rig_.open_line();
  EXPECT_THAT(answer_all(), ElementsAre(kSecond, kStop1));
}

TEST_F(FailsafeWrites, ThatAReloadHasTakenAwayAreNotDueAnyMore) {
  come(1);
  rig_.disconnect(1);
  EXPECT_THAT(take_requests(rig_), ElementsAre(kStop1));
  Settings changed = watched_plant();
  changed.guards.clear();
  rig_.reload(changed);
  rig_.lose_line();
  rig_.open_line();
  EXPECT_THAT(answer_all(), IsEmpty());
  EXPECT_THAT(rig_.events, ElementsAre(kLost, "bus line-a is open"));
}

TEST_F(FailsafeWrites, ThatCouldNotBeSentAreSaidAtTheEnd) {
  come(1);
  rig_.lose_line();
  rig_.disconnect(1);
  rig_.shutdown();
  EXPECT_THAT(rig_.events,
              ElementsAre(kLost, kNotYet,
                          "device axis-x: its failsafe writes could not be sent before "
                          "the gateway stopped"));
  EXPECT_TRUE(rig_.finished);
}

}  // namespace
}  // namespace mbgate::test
