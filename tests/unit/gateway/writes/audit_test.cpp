// SPDX-License-Identifier: Apache-2.0
// What the journal is told of what clients may do, and do: writes (`audit = true`), cleared
// counters, logins.
#include <gmock/gmock.h>

#include "unit/gateway/writes/stop_plant.hpp"

namespace mbgate::test {
namespace {

using routing::ClientRole;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

constexpr std::string_view kClearAll = "0002 0000 0006 FF 08 000A 0000 ";
const std::string kWriting = "listener plant: client 192.0.2.1";

Settings audited(bool audit = true) {
  Settings settings = stop_plant(16);
  settings.audit = audit;
  return settings;
}

TEST(Audit, TellsOfEachWriteThatIsAcceptedOnce) {
  MachineRig rig(audited());
  rig.connect(1);
  rig.receive(1, read_request(1) + write_request(2) + write_request(3));
  EXPECT_THAT(rig.events,
              ElementsAre(kWriting + " writes (device axis-x): function 6 at unit 1, holding "
                                     "register 0 = 1",
                          kWriting + " writes (device axis-x): function 6 at unit 1, holding "
                                     "register 0 = 1"));
  rig.respond("01 03 02 00 01");
  rig.advance(10ms);
  rig.respond(kWrite1);
  rig.advance(10ms);
  rig.respond(kWrite1);
  EXPECT_THAT(rig.events, SizeIs(2));
}

TEST(Audit, IsOffByDefaultAndFollowsAReload) {
  MachineRig rig(audited(false));
  rig.connect(1);
  rig.receive(1, write_request(1));
  EXPECT_THAT(rig.events, IsEmpty());
  rig.reload(audited());
  rig.receive(1, write_request(2));
  EXPECT_THAT(rig.events, SizeIs(1));
  rig.reload(audited(false));
  rig.receive(1, write_request(3));
  EXPECT_THAT(rig.events, SizeIs(1));
}

TEST(Audit, TellsOfAStopOnceThoughItIsTakenEarly) {
  Settings settings = audited();
  settings.listeners[0].pipeline = 1;
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, read_request(1, 2) + stop_request(2));
  rig.respond(kStop1);
  rig.advance(10ms);
  rig.respond("02 03 02 00 01");
  rig.advance(10ms);
  EXPECT_THAT(rig.events, ElementsAre(kWriting + " stops (device axis-x): function 6 at unit 1, "
                                                 "holding register 124 = 225"));
}

TEST(Audit, LeavesNothingOutHoweverManyThereAre) {
  MachineRig rig(audited());
  rig.connect(1);
  for (unsigned at = 0; at < 200; ++at) {
    rig.receive(1, write_request(at));
    rig.respond(kWrite1);
    rig.advance(10ms);
  }
  EXPECT_THAT(rig.events, SizeIs(200));
}

TEST(Audit, DoesNotTellOfWhatIsNotAccepted) {
  Settings settings = audited();
  settings.routes[0].access = routing::Access::read_only;
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, write_request(1));
  EXPECT_THAT(rig.events, ElementsAre(HasSubstr("denied by access of the route")));
}

TEST(Audit, NamesTheRoleAndABroadcastByItsBus) {
  Settings settings = audited();
  settings.routes.emplace_back().buses = {BusId{0}};  // unit 0
  MachineRig rig(settings);
  rig.connect(1, "192.0.2.1", 0, {}, {ClientRole::Kind::named, "operator", "hmi"});
  rig.events.clear();
  rig.receive(1, write_request(1, 0));
  EXPECT_THAT(
      rig.events,
      ElementsAre(
          kWriting +
          " (role \"operator\", certificate \"hmi\") writes (bus line-a: address 0): function "
          "6 at unit 0, holding register 0 = 1"));
}

TEST(Audit, TellsAlwaysWhoHasClearedTheCounters) {
  for (const bool audit : {false, true}) {
    MachineRig rig(audited(audit));
    rig.connect(1);
    rig.receive(1, kClearAll);
    EXPECT_THAT(rig.events, ElementsAre(kWriting + " has cleared all counters: function 8 at unit "
                                                   "255, sub-function 10"));
    for (unsigned at = 0; at < 100; ++at) {
      rig.receive(1, kClearAll);
    }
    EXPECT_THAT(rig.events, SizeIs(10));  // a minute
  }
}

TEST(Audit, TellsAlwaysWhoHasLoggedInWithACertificate) {
  MachineRig rig(audited(false));
  rig.connect(1);
  EXPECT_THAT(rig.events, IsEmpty());
  rig.connect(2, "192.0.2.1", 0, {}, {ClientRole::Kind::named, "operator"});
  rig.connect(3, "192.0.2.1", 0, {}, {ClientRole::Kind::named, ""});
  rig.connect(4, "192.0.2.1", 0, {}, {ClientRole::Kind::unreadable});
  const std::string end = " has logged in with its certificate";
  EXPECT_THAT(rig.events,
              ElementsAre(kWriting + " (role \"operator\")" + end, kWriting + " (no role)" + end,
                          kWriting + " (its role cannot be read)" + end));
}

}  // namespace
}  // namespace mbgate::test
