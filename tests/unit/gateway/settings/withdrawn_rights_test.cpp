// SPDX-License-Identifier: Apache-2.0
// A reload takes rights away: what waits is answered 06, and what is on the wire goes on.
#include <gmock/gmock.h>

#include <functional>

#include "unit/gateway/writes/stop_plant.hpp"

namespace mbgate::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// A read of axis-x is on the wire; writes to axis-x and axis-y wait behind it.
class WithdrawnRights : public testing::Test {
 protected:
  WithdrawnRights() {
    rig_.connect(1);
    rig_.receive(1, read_request(1));
    rig_.receive(1, write_request(2) + write_request(3, 2));
    EXPECT_THAT(take_requests(rig_), ElementsAre(kRead1));
  }
  /// What is transmitted after new settings, once the read is answered.
  Lines sent_after(const std::function<void(Settings&)>& change) {
    Settings settings = stop_plant(16);
    change(settings);
    rig_.reload(settings);
    Lines sent;
    for (const auto* const answer : {"01 03 02 00 01", "01 06 00 00 00 01", "02 06 00 00 00 01"}) {
      rig_.respond(answer);
      rig_.advance(10ms);
      for (const auto& request : take_requests(rig_)) {
        sent.push_back(request);
      }
    }
    return sent;
  }
  MachineRig rig_{stop_plant(16)};
};

TEST_F(WithdrawnRights, WhoMayDoWhatItMightGoesOn) {
  EXPECT_THAT(sent_after([](Settings&) {}), ElementsAre(kWrite1, kWrite2));
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(kOne, written(2), written(3, 2)));
}

TEST_F(WithdrawnRights, AClientThatMayOnlyRead) {
  EXPECT_THAT(sent_after([](Settings& settings) {
                settings.listeners[0].read_only.networks = {*routing::Network::parse("192.0.2.1")};
              }),
              IsEmpty());
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(busy(2), busy(3, 2), kOne));
}

TEST_F(WithdrawnRights, ARouteThatOnlyReads) {
  EXPECT_THAT(sent_after([](Settings& settings) {
                settings.routes[0].access = routing::Access::read_only;
              }),
              IsEmpty());
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(busy(2), busy(3, 2), kOne));
}

TEST_F(WithdrawnRights, ARouteThatHasOtherFunctions) {
  EXPECT_THAT(sent_after([](Settings& settings) { settings.routes[0].functions.allowed.reset(6); }),
              IsEmpty());
}

TEST_F(WithdrawnRights, ARuleThatDeniesOneDevice) {
  EXPECT_THAT(sent_after([](Settings& settings) {
                settings.rules.resize(2);
                settings.rules[0].permits = false;
                settings.rules[0].access = routing::RuleAccess::write;
                settings.rules[0].devices = {1};
              }),
              ElementsAre(kWrite1));
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(busy(3, 2), kOne, written(2)));
}

TEST_F(WithdrawnRights, AnotherWriter) {
  EXPECT_THAT(sent_after([](Settings& settings) {
                settings.guards.resize(1);
                settings.guards[0].writer = gateway::WriterRule::listed;
              }),
              ElementsAre(kWrite2));
}

TEST_F(WithdrawnRights, ARegisterThatNowReconfigures) {
  EXPECT_THAT(
      sent_after([](Settings& settings) {
        settings.routes[0].device = 0;
        settings.routes[0].first_unit = settings.routes[0].last_unit = 1;
        settings.devices[0].profile.communication = {{modbus::Table::holding_registers, 0, 1}};
      }),
      IsEmpty());
}

TEST_F(WithdrawnRights, OtherRegistersBehindTheSameNumbers) {
  EXPECT_THAT(sent_after([](Settings& settings) {
                settings.routes[0].windows = {
                    {modbus::Table::holding_registers, 0, 10, modbus::Table::holding_registers, 5}};
              }),
              IsEmpty());
}

// Once more, because what comes is not its echo.
TEST_F(WithdrawnRights, AStopIsSentAllTheSame) {
  rig_.receive(1, stop_request(4));
  EXPECT_THAT(sent_after([](Settings& settings) {
                settings.routes[0].access = routing::Access::read_only;
              }),
              ElementsAre(kStop1, kStop1));
}

}  // namespace
}  // namespace mbgate::test
