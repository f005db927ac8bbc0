// SPDX-License-Identifier: Apache-2.0
// What is written to a device when nobody is left who might.
#include <gmock/gmock.h>

#include "unit/gateway/stop_plant.hpp"

namespace mbgate::test {
namespace {

using gateway::Failsafe;
using gateway::FailsafeReason;
using testing::ElementsAre;
using testing::IsEmpty;

/// When each device was due, in the order of take_due(); negative for silence.
std::vector<int> due(Failsafe& failsafe, Instant now) {
  std::vector<int> devices;
  while (const auto it = failsafe.take_due(now)) {
    const auto device = static_cast<int>(it->device);
    devices.push_back(it->reason == FailsafeReason::silent ? -device : device);
  }
  return devices;
}

/// A client that may write to the devices, and has asked something.
void come(Failsafe& failsafe, std::uint64_t client, const gateway::DevicePlaces& devices,
          Instant now = {}) {
  failsafe.client_came(ClientId{client}, devices);
  failsafe.client_asked(ClientId{client}, now);
}

TEST(Failsafe, IsDueWhenTheLastClientHasGone) {
  Failsafe failsafe;
  failsafe.watch(7, 0ms);
  come(failsafe, 1, {7}, Instant{});
  come(failsafe, 2, {7}, Instant{});
  failsafe.client_gone(ClientId{1});
  EXPECT_THAT(due(failsafe, Instant{}), IsEmpty());
  failsafe.client_gone(ClientId{2});
  EXPECT_THAT(due(failsafe, Instant{}), ElementsAre(7));
  EXPECT_THAT(due(failsafe, Instant(1h)), IsEmpty());
  EXPECT_EQ(failsafe.next(), std::nullopt);
}

TEST(Failsafe, IsDueOnceWhenAllAreSilentUntilOneAsksAgain) {
  Failsafe failsafe;
  failsafe.watch(7, 100ms);
  come(failsafe, 1, {7}, Instant{});
  come(failsafe, 2, {7}, Instant(50ms));
  failsafe.client_asked(ClientId{1}, Instant(60ms));
  EXPECT_THAT(due(failsafe, Instant(159ms)), IsEmpty());
  EXPECT_EQ(failsafe.next(), Instant(160ms));
  EXPECT_THAT(due(failsafe, Instant(160ms)), ElementsAre(-7));
  EXPECT_EQ(failsafe.next(), std::nullopt);
  failsafe.client_asked(ClientId{2}, Instant(500ms));
  EXPECT_EQ(failsafe.next(), Instant(600ms));
  EXPECT_THAT(due(failsafe, Instant(600ms)), ElementsAre(-7));
}

TEST(Failsafe, IsNotDueAgainWhenThoseWhoWereSilentGo) {
  Failsafe failsafe;
  failsafe.watch(7, 100ms);
  come(failsafe, 1, {7}, Instant{});
  EXPECT_THAT(due(failsafe, Instant(100ms)), ElementsAre(-7));
  failsafe.client_gone(ClientId{1});
  EXPECT_THAT(due(failsafe, Instant(200ms)), IsEmpty());
  come(failsafe, 2, {7}, Instant(300ms));
  failsafe.client_gone(ClientId{2});
  EXPECT_THAT(due(failsafe, Instant(300ms)), ElementsAre(7));
}

TEST(Failsafe, DoesNotCountThoseWhoNeverAsk) {
  Failsafe failsafe;
  failsafe.watch(7, 100ms);
  failsafe.client_came(ClientId{1}, {7});
  EXPECT_EQ(failsafe.next(), std::nullopt);
  come(failsafe, 2, {7});
  failsafe.client_gone(ClientId{2});
  EXPECT_THAT(due(failsafe, Instant{}), ElementsAre(7));
  failsafe.client_gone(ClientId{1});
  EXPECT_THAT(due(failsafe, Instant(1h)), IsEmpty());
}

TEST(Failsafe, IsDueAgainIfItCouldNotBeSentAndNobodyAsks) {
  Failsafe failsafe;
  failsafe.watch(7, 0ms);
  come(failsafe, 1, {7});
  failsafe.client_gone(ClientId{1});
  const auto first = failsafe.take_due(Instant{});
  ASSERT_TRUE(first);
  EXPECT_TRUE(failsafe.put_back(*first));
  EXPECT_THAT(due(failsafe, Instant{}), IsEmpty());
  EXPECT_EQ(failsafe.next(), Instant(1s));
  failsafe.line_is_back(7);
  EXPECT_THAT(due(failsafe, Instant(1ms)), ElementsAre(7));
  come(failsafe, 2, {7});
  EXPECT_FALSE(failsafe.put_back(*first));
  EXPECT_THAT(due(failsafe, Instant(1h)), IsEmpty());
}

TEST(Failsafe, LooksAtEachDeviceAlone) {
  Failsafe failsafe;
  failsafe.watch(7, 100ms);
  failsafe.watch(8, 300ms);
  come(failsafe, 1, {7, 8}, Instant{});
  EXPECT_THAT(due(failsafe, Instant(100ms)), ElementsAre(-7));
  EXPECT_EQ(failsafe.next(), Instant(300ms));
  failsafe.client_gone(ClientId{1});
  EXPECT_THAT(due(failsafe, Instant(100ms)), ElementsAre(8));
}

TEST(Failsafe, DoesNotTakeThoseForSilentWhoWaitForAnAnswer) {
  Failsafe failsafe;
  failsafe.watch(7, 100ms);
  come(failsafe, 1, {7}, Instant{});
  come(failsafe, 2, {7}, Instant{});
  failsafe.client_asked(ClientId{1}, Instant(10ms));
  failsafe.client_waits(ClientId{1}, true, Instant(10ms));
  EXPECT_THAT(due(failsafe, Instant(200ms)), IsEmpty());
  failsafe.client_waits(ClientId{1}, false, Instant(250ms));
  EXPECT_EQ(failsafe.next(), Instant(350ms));
  EXPECT_THAT(due(failsafe, Instant(350ms)), ElementsAre(-7));
}

TEST(Failsafe, CountsTheSilenceOfTheOthersWhenOneWhoWaitedHasGone) {
  Failsafe failsafe;
  failsafe.watch(7, 100ms);
  come(failsafe, 1, {7}, Instant{});
  come(failsafe, 2, {7}, Instant{});
  failsafe.client_asked(ClientId{1}, Instant(10ms));
  failsafe.client_waits(ClientId{1}, true, Instant(10ms));
  EXPECT_THAT(due(failsafe, Instant(200ms)), IsEmpty());
  failsafe.client_gone(ClientId{1});
  EXPECT_THAT(due(failsafe, Instant(200ms)), ElementsAre(-7));
}

modbus::Request write_of(std::string_view pdu) {
  return *modbus::Request::parse(*modbus::Pdu::from(unhex(pdu)));
}

/// Device 1: first a stop, then something that is none.
Settings watched_plant() {
  Settings settings = stop_plant();
  settings.guards.resize(1);
  settings.guards[0].failsafe = {write_of("06 007C 00E1"), write_of("06 0010 0007")};
  settings.listeners.push_back(settings.listeners[0]);
  settings.listeners[1].name = "screens";
  settings.listeners[1].read_only = {*routing::Network::parse("192.0.2.0/24")};
  return settings;
}

constexpr auto kSecond = "01 06 00 10 00 07";
constexpr auto kLost = "bus line-a is lost; it is being reopened";
constexpr auto kSent =
    "device axis-x: the last client that may write has gone; its failsafe writes are sent";
constexpr auto kNotYet =
    "device axis-x: the last client that may write has gone; its failsafe writes could not be sent "
    "yet";

/// A read of unit 2, answered.
void ask(MachineRig& rig, std::uint64_t client) {
  rig.receive(client, read_request(99, 2));
  rig.respond("02 03 02 00 01");
  rig.advance(10ms);
  rig.take_transmitted();
  rig.take_sent(client);
}

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
  EXPECT_THAT(rig_.events,
              ElementsAre(kLost, kNotYet,
                          "device axis-x: a client that may write asks again; its failsafe writes "
                          "were not all sent"));
  rig_.open_line();
  EXPECT_THAT(answer_all(), IsEmpty());
  rig_.disconnect(2);
  EXPECT_THAT(answer_all(), ElementsAre(kStop1, kSecond));
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

class FailsafeOnExit : public testing::Test {
 protected:
  static Settings settings() {
    Settings settings = watched_plant();
    settings.guards[0].failsafe_on_exit = true;
    return settings;
  }
  MachineRig rig_{settings()};
};

TEST_F(FailsafeOnExit, SendsThemWhenTheGatewayStops) {
  rig_.connect(1);
  ask(rig_, 1);
  rig_.receive(1, read_request(1, 2) + write_request(2));
  take_requests(rig_);
  rig_.shutdown();
  rig_.respond("02 03 02 00 01");
  rig_.advance(10ms);
  rig_.respond(kStop1);
  rig_.advance(10ms);
  EXPECT_FALSE(rig_.finished);
  rig_.respond(kSecond);
  EXPECT_THAT(take_requests(rig_), ElementsAre(kStop1, kSecond));
  EXPECT_THAT(rig_.events, ElementsAre("device axis-x: the gateway stops; its failsafe writes are "
                                       "sent"));
  EXPECT_TRUE(rig_.finished);
}

TEST_F(FailsafeOnExit, SendsNothingIfNobodyAskedSinceTheyWereSent) {
  rig_.connect(1);
  rig_.shutdown();
  EXPECT_THAT(take_requests(rig_), IsEmpty());
  EXPECT_TRUE(rig_.finished);
}

TEST_F(FailsafeOnExit, SaysWhatCouldNotBeSent) {
  rig_.connect(1);
  ask(rig_, 1);
  rig_.lose_line();
  rig_.shutdown();
  EXPECT_THAT(rig_.events, ElementsAre(kLost,
                                       "device axis-x: its failsafe writes could not be sent "
                                       "before the gateway stopped"));
  EXPECT_TRUE(rig_.finished);
}

TEST(SilentWriters, AreReasonEnoughWhereQuietSaysSo) {
  Settings settings = watched_plant();
  settings.guards[0].quiet = 1s;
  MachineRig rig(settings);
  rig.connect(1);
  rig.advance(900ms);
  rig.receive(1, read_request(1, 2));  // any request counts
  rig.respond("02 03 02 00 01");
  rig.advance(999ms);
  rig.take_transmitted();
  rig.advance(1ms);
  EXPECT_THAT(take_requests(rig), ElementsAre(kStop1));
  rig.respond(kStop1);
  rig.advance(10ms);
  EXPECT_THAT(take_requests(rig), ElementsAre(kSecond));
  EXPECT_THAT(rig.events, ElementsAre("device axis-x: the clients that may write are silent; its "
                                      "failsafe writes are sent"));
}

TEST(SilentWriters, AreThoseToWhomNoAnswerIsOwed) {
  Settings settings = watched_plant();
  settings.guards[0].quiet = 100ms;
  settings.devices[1].timing.response_timeout = 1s;
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, read_request(1, 2));
  rig.advance(900ms);
  rig.respond("02 03 02 00 01");
  rig.advance(99ms);
  EXPECT_THAT(rig.events, IsEmpty());
  rig.take_transmitted();
  rig.advance(1ms);
  EXPECT_THAT(take_requests(rig), ElementsAre(kStop1));
}

TEST(ListedWriter, IsTheOnlyOneThatKeepsFailsafeWritesBack) {
  Settings settings = watched_plant();
  settings.guards[0].writer = gateway::WriterRule::listed;
  settings.guards[0].writers = {*routing::Network::parse("192.0.2.1")};
  MachineRig rig(settings);
  rig.connect(1, "192.0.2.1");
  rig.connect(2, "192.0.2.2");
  ask(rig, 1);
  ask(rig, 2);
  rig.disconnect(1);
  EXPECT_THAT(take_requests(rig), ElementsAre(kStop1));
}

}  // namespace
}  // namespace mbgate::test
