// SPDX-License-Identifier: Apache-2.0
// When a device's failsafe writes are due.
#include <gmock/gmock.h>

#include "support/machine_rig.hpp"

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

TEST(Failsafe, WhatWasSentBeforeItWasDueOnceMoreStaysDue) {
  Failsafe failsafe;
  failsafe.watch(7, 0ms);
  std::vector<Failsafe::Due> runs;
  for (const std::uint64_t client : {1U, 2U}) {
    come(failsafe, client, {7});
    failsafe.client_gone(ClientId{client});
    runs.push_back(*failsafe.take_due(Instant{}));
  }
  runs[0].sent = {0, 1};
  runs[1].sent = {1};
  for (const Failsafe::Due& run : runs) {
    EXPECT_TRUE(failsafe.put_back(run));
  }
  failsafe.line_is_back(7);
  EXPECT_THAT(failsafe.take_due(Instant{})->sent, ElementsAre(1));
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

// Nobody has asked since they were due, whoever may write by now.
TEST(Failsafe, IsDueAgainThoughOtherSettingsLetSomebodyWriteWhoAskedBefore) {
  Failsafe old;
  old.watch(7, 0ms);
  come(old, 1, {7});
  old.client_gone(ClientId{1});
  const auto sent = old.take_due(Instant{});
  ASSERT_TRUE(sent);
  Failsafe next;
  next.watch(7, 0ms);
  come(next, 2, {7}, Instant(1s));
  next.carry(7, old, true);
  EXPECT_TRUE(next.put_back(*sent));
  EXPECT_THAT(due(next, Instant(2s)), IsEmpty());
  EXPECT_THAT(due(next, Instant(1h)), ElementsAre(7));
}

// What the answer is for it has asked when it was not allowed to write.
TEST(Failsafe, IsDueAgainThoughSomebodyIsAnsweredWhomOtherSettingsLetWrite) {
  Failsafe old;
  old.watch(7, 0ms);
  come(old, 1, {7});
  old.client_gone(ClientId{1});
  const auto sent = old.take_due(Instant{});
  ASSERT_TRUE(sent);
  Failsafe next;
  next.watch(7, 0ms);
  come(next, 2, {7}, Instant(1s));
  next.client_waits(ClientId{2}, true, Instant(1s));
  next.carry(7, old, true);
  next.client_waits(ClientId{2}, false, Instant(2s));
  EXPECT_TRUE(next.put_back(*sent));
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

}  // namespace
}  // namespace mbgate::test
