// SPDX-License-Identifier: Apache-2.0
// What a stop is, and which writes it forbids, without a gateway around.
#include "gateway/writes/write_rules.hpp"

#include <gtest/gtest.h>

#include "unit/gateway/parts_plant.hpp"

namespace mbgate::test {
namespace {

using modbus::ExceptionCode;

class WriteRulesAlone : public testing::Test {
 protected:
  routing::Plan plan(std::string_view pdu, std::uint8_t unit = 1) {
    const auto bytes = unhex(pdu);
    return *routing::Plan::make(*settings_.routes.find(ListenerId{0}, unit), unit, {},
                                *modbus::Pdu::from(bytes));
  }
  static gateway::WriteOrigin from(std::uint64_t client, Instant arrival) {
    static const gateway::ClientInfo kInfo = info_of("192.0.2.1");
    static const gateway::ClientKey kKey{kInfo.address};
    return {ClientId{client}, kInfo, kKey, arrival};
  }
  std::optional<ExceptionCode> objection(const gateway::WriteOrigin& origin,
                                         std::uint8_t unit = 1) {
    const auto found = rules_.objection(plan("06 00 00 00 01", unit), origin, Instant{10s});
    return found ? std::optional(found->code) : std::nullopt;
  }

  gateway::SettingsSnapshot settings_{stop_plant()};
  gateway::WriteRules rules_{settings_};
};

TEST_F(WriteRulesAlone, AStopIsWhatItsDeviceTakesForOne) {
  EXPECT_TRUE(rules_.is_stop(plan("06 00 7C 00 E1")));
  EXPECT_FALSE(rules_.is_stop(plan("06 00 7C 00 E2")));
  EXPECT_FALSE(rules_.is_stop(plan("03 00 7C 00 01")));
  EXPECT_FALSE(rules_.is_stop(plan("06 00 7C 00 E1", 3)));  // no device is known there
}

TEST_F(WriteRulesAlone, AStopForbidsWhatOthersSentBeforeItToItsDevice) {
  rules_.note_accepted(plan("06 00 7C 00 E1"), from(1, Instant{5s}), Instant{5s});
  EXPECT_EQ(objection(from(2, Instant{4s})), ExceptionCode::server_device_busy);
  EXPECT_EQ(objection(from(2, Instant{6s})), std::nullopt);
  EXPECT_EQ(objection(from(2, Instant{4s}), 2), std::nullopt);
  EXPECT_EQ(objection(from(1, Instant{4s})), std::nullopt);  // behind its own stop
}

TEST_F(WriteRulesAlone, AStopForbidsWhatWasAcceptedBeforeIt) {
  const routing::Plan move = plan("06 00 00 00 01");
  const auto before = rules_.note_accepted(move, from(1, Instant{5s}), Instant{5s});
  rules_.note_accepted(plan("06 00 7C 00 E1"), from(1, Instant{5s}), Instant{5s});
  const auto after = rules_.note_accepted(move, from(1, Instant{5s}), Instant{5s});
  EXPECT_TRUE(rules_.was_stopped(move, before));
  EXPECT_FALSE(rules_.was_stopped(move, after));
  EXPECT_FALSE(rules_.was_stopped(plan("06 00 00 00 01", 2), before));
  EXPECT_FALSE(rules_.was_stopped(plan("03 00 00 00 01"), before));
  rules_.note_own_stop(0, Instant{6s});
  EXPECT_TRUE(rules_.was_stopped(move, after));
}

TEST_F(WriteRulesAlone, NothingIsKnownOfADeviceThatWasGone) {
  rules_.note_accepted(plan("06 00 7C 00 E1"), from(1, Instant{5s}), Instant{5s});
  Settings less = stop_plant();
  less.routes.clear();
  less.devices[0].bus = drive::kNoBus;
  const gateway::SettingsSnapshot without(less);
  rules_.adopt(without);
  rules_.adopt(settings_);
  EXPECT_EQ(objection(from(2, Instant{4s})), std::nullopt);
}

TEST_F(WriteRulesAlone, NobodyOwnsADeviceThatWasGone) {
  Settings guarded = stop_plant();
  guarded.guards.resize(1);
  guarded.guards[0].writer = gateway::WriterRule::first;
  const gateway::SettingsSnapshot snapshot(guarded);
  rules_.adopt(snapshot);
  const gateway::ClientInfo other = info_of("192.0.2.2");
  const gateway::ClientKey key{other.address};
  const gateway::WriteOrigin second{ClientId{2}, other, key, Instant{10s}};
  rules_.note_accepted(plan("06 00 00 00 01"), from(1, Instant{9s}), Instant{9s});
  EXPECT_EQ(objection(second), ExceptionCode::server_device_busy);
  rules_.adopt(snapshot);
  EXPECT_EQ(objection(second), ExceptionCode::server_device_busy);
  Settings less = guarded;
  less.routes.clear();
  less.devices[0].bus = drive::kNoBus;
  const gateway::SettingsSnapshot without(less);
  rules_.adopt(without);
  rules_.adopt(snapshot);
  EXPECT_EQ(objection(second), std::nullopt);
}

}  // namespace
}  // namespace mbgate::test
