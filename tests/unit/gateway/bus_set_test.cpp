// SPDX-License-Identifier: Apache-2.0
// The buses alone: who has something to say, and what other settings make of them.
#include "gateway/bus_set.hpp"

#include <gtest/gtest.h>

#include "unit/gateway/parts_plant.hpp"

namespace mbgate::test {
namespace {

Settings two_buses() {
  Settings settings = one_bus();
  settings.buses.push_back(settings.buses[0]);
  settings.buses[1].name = "line-b";
  settings.buses[1].line.device = "/dev/ttyS1";
  return settings;
}

void collect(gateway::BusSet& buses) {
  while (const auto bus = buses.take_touched()) {
    while (buses.poll(*bus)) {
    }
  }
}

TEST(BusesAlone, EachIsCollectedOnceHoweverOftenItWasTouched) {
  gateway::BusSet buses(two_buses());
  static_cast<void>(buses.touch(BusId{1}));
  EXPECT_EQ(buses.take_touched(), BusId{1});
  EXPECT_EQ(buses.take_touched(), BusId{0});
  EXPECT_EQ(buses.take_touched(), std::nullopt);
}

TEST(BusesAlone, WakeForTheirEarliestOrForTheJudgementBeforeIt) {
  gateway::BusSet buses(two_buses());
  buses.touch(BusId{0}).handle_opened(Instant{1s}, bus::LineKind::virtual_line);
  buses.touch(BusId{1}).handle_lost(Instant{1s});
  collect(buses);
  const auto reopening = buses[BusId{1}].next_wake();
  ASSERT_TRUE(reopening);
  EXPECT_EQ(buses.next_wake(std::nullopt)->at, reopening->at);
  EXPECT_EQ(buses.next_wake(Instant{1s})->at, Instant{1s});
  EXPECT_EQ(buses.open_count(), 1U);
}

bus::Job waiting_read() {
  bus::Job job;
  job.deadline = Instant{1min};
  job.transactions.push_back(
      {1, *modbus::Request::parse(*modbus::Pdu::from(unhex("03 0000 0001")))});
  return job;
}

TEST(BusesAlone, SayWhoseSilenceEndsWhenTheyWake) {
  std::array jobs{waiting_read(), waiting_read()};
  gateway::BusSet buses(two_buses());
  for (const std::uint32_t id : {0U, 1U}) {
    bus::Bus& bus = buses.touch(BusId{id});
    bus.handle_opened(Instant{1s}, bus::LineKind::virtual_line);
    bus.handle_bytes(unhex("55"), Instant{20s - 1ms * id});  // that of the second one comes first
    EXPECT_TRUE(bus.submit(jobs.at(id), Instant{20s}));
  }
  collect(buses);
  const auto wake = buses.next_wake(std::nullopt);
  EXPECT_EQ(wake->at, buses[BusId{1}].next_wake()->at);
  EXPECT_EQ(wake->silence_of, BusId{1});
  EXPECT_EQ(buses.next_wake(Instant{20s})->silence_of, std::nullopt);
}

TEST(BusesAlone, OtherSettingsKeepABusThatKeepsItsLineAndGiveUpTheOther) {
  const Settings before = two_buses();
  gateway::BusSet buses(before);
  const bus::Bus* const kept = &buses[BusId{1}];
  Settings next = two_buses();
  next.buses[0].line.device = "/dev/ttyS7";
  const auto given_up = buses.adopt(before, next, Instant{1s});
  EXPECT_EQ(&buses[BusId{1}], kept);
  ASSERT_EQ(given_up.size(), 1U);
  EXPECT_EQ(given_up[0].id, BusId{0});
  EXPECT_TRUE(buses.is_there(BusId{0}));
}

TEST(BusesAlone, OneThatIsGoneHasNothingToSayAnyMore) {
  const Settings before = two_buses();
  gateway::BusSet buses(before);
  Settings next = two_buses();
  next.buses[0].is_gone = true;
  EXPECT_EQ(buses.adopt(before, next, Instant{1s}).size(), 1U);
  EXPECT_FALSE(buses.is_there(BusId{0}));
  EXPECT_EQ(buses.take_touched(), BusId{1});
  EXPECT_EQ(buses.take_touched(), std::nullopt);
  EXPECT_TRUE(buses.adopt(next, before, Instant{2s}).empty());
  EXPECT_TRUE(buses.is_there(BusId{0}));
}

}  // namespace
}  // namespace mbgate::test
