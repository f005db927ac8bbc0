// SPDX-License-Identifier: Apache-2.0
// Open requests, and the buses that carry them, without clients.
#include "gateway/exchanges/exchanges.hpp"

#include <gtest/gtest.h>

#include "unit/gateway/parts_plant.hpp"

namespace mbgate::test {
namespace {

class ExchangesAlone : public testing::Test {
 protected:
  ExchangesAlone() { buses_.touch(BusId{0}).handle_opened({}, bus::LineKind::virtual_line); }
  std::uint32_t ask(std::string_view pdu) {
    const auto* route = settings_.in_force().routes.find(ListenerId{0}, 1);
    const std::uint32_t index =
        exchanges_.open(*routing::Plan::make(*route, 1, {}, *modbus::Pdu::from(unhex(pdu))));
    exchanges_[index].route = route;
    exchanges_[index].header = {1, 1};
    exchanges_[index].deadline = exchanges_.deadline_of(exchanges_[index]);
    exchanges_.start(index, {}, {});
    return index;
  }

  SettingsHistory settings_{stop_plant()};
  ActionQueue actions_;
  gateway::Exchanges exchanges_{settings_, buses_, actions_};
  gateway::BusSet buses_{settings_.settings()};
};

TEST_F(ExchangesAlone, AreCompletedWhenAllTheirJobsHaveEnded) {
  const std::uint32_t index = ask("03 00 00 00 01");
  EXPECT_EQ(exchanges_.take_completed(), std::nullopt);
  bus::Job& job = *exchanges_[index].parts.front().job;
  buses_.touch(BusId{0}).withdraw(job);
  exchanges_.end(job, bus::Ending::no_answer);
  EXPECT_EQ(exchanges_.take_completed(), index);
  EXPECT_TRUE(exchanges_[index].result()->is_exception());
  exchanges_.close(index);
  EXPECT_EQ(exchanges_.open_count(), 0U);
}

TEST_F(ExchangesAlone, CountTheTransactionsOfThoseThatAreOpen) {
  const std::uint32_t index = ask("03 00 00 00 01");
  ask("06 00 00 00 02");
  EXPECT_EQ(exchanges_.planned(), 2U);
  exchanges_.cancel(index);
  exchanges_.close(*exchanges_.take_completed());
  EXPECT_EQ(exchanges_.planned(), 1U);
}

TEST_F(ExchangesAlone, OfAnOfflineDeviceAReadGets0BAndAWriteThatItWasNotTransmitted) {
  struct Case {
    const char* asked;
    modbus::ExceptionCode code;
  };
  using enum modbus::ExceptionCode;
  for (const Case& it : {Case{"03 00 00 00 01", gateway_target_failed_to_respond},
                         Case{"06 00 00 00 02", server_device_busy}}) {
    const std::uint32_t index = ask(it.asked);
    bus::Job& job = *exchanges_[index].parts.front().job;
    buses_.touch(BusId{0}).withdraw(job);
    exchanges_.end(job, bus::Ending::offline);
    EXPECT_EQ(exchanges_[index].result()->bytes()[1], static_cast<std::uint8_t>(it.code));
    exchanges_.close(*exchanges_.take_completed());
  }
}

TEST_F(ExchangesAlone, KeepTheSettingsTheyBeganWith) {
  const std::uint32_t index = ask("03 00 00 00 01");
  const gateway::SettingsSnapshot* const before = exchanges_[index].snapshot;
  settings_.adopt(stop_plant());
  settings_.forget_unused();
  EXPECT_EQ(exchanges_[index].snapshot, before);
  EXPECT_EQ(before->exchanges, 1U);
  exchanges_.cancel(index);
  exchanges_.close(*exchanges_.take_completed());
}

TEST_F(ExchangesAlone, WhatWaitsIsTakenBackAndAStopIsNot) {
  const std::uint32_t waiting = ask("06 00 00 00 02");
  exchanges_.cancel(waiting);
  EXPECT_TRUE(exchanges_[waiting].parts.empty());
  const std::uint32_t stop = ask("06 00 7C 00 E1");
  exchanges_.cancel(stop);
  EXPECT_FALSE(exchanges_[stop].parts.empty());
}

}  // namespace
}  // namespace mbgate::test
