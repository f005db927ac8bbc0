// SPDX-License-Identifier: Apache-2.0
#include "gateway/access/who.hpp"

#include <gtest/gtest.h>

#include "unit/gateway/writes/stop_plant.hpp"

namespace mbgate::test {
namespace {

using gateway::DenyingKey;

class Who : public testing::Test {
 protected:
  std::string may(std::string_view client, unsigned unit, std::string_view pdu) {
    const gateway::SettingsSnapshot snapshot(settings_);
    gateway::ClientInfo info;
    info.address = *routing::ClientAddress::parse(client);
    info.role = role_;
    const auto answer = gateway::who_may(snapshot, info, static_cast<std::uint8_t>(unit),
                                         *modbus::Pdu::from(unhex(pdu)));
    EXPECT_EQ(answer.permitted, answer.by.starts_with("permitted")) << answer.by;
    key_ = answer.key;
    return answer.text();
  }
  /// The key that has denied the last one.
  [[nodiscard]] bool is_by(DenyingKey::Name name, std::size_t entry) const {
    return key_ && key_->name == name && key_->entry == entry;
  }
  void add_rule(bool permits, std::string place) {
    auto& rule = settings_.rules.emplace_back();
    rule.permits = permits;
    rule.place = std::move(place);
  }
  Settings settings_ = stop_plant();
  routing::ClientRole role_{};
  std::optional<DenyingKey> key_{};
};

constexpr auto kWrite = "06 0010 0001";
constexpr auto kStop = "06 007C 00E1";
constexpr auto kRead = "03 0010 0001";

TEST_F(Who, WithoutRulesIsPermittedByNone) {
  EXPECT_EQ(may("192.0.2.1", 1, kWrite), "permitted: there are no rules");
  EXPECT_EQ(may("192.0.2.1", 255, "04 0000 0001"), "permitted: there are no rules");
}

TEST_F(Who, AsksTheGatewayItselfForItsStatusOnly) {
  constexpr auto kDenied =
      "denied: the unit is the gateway itself, with its status in input registers (function 4): "
      "exception 01";
  for (const auto* pdu : {kWrite, kRead, "10 0010 0001 02 0001", "11"}) {
    EXPECT_EQ(may("192.0.2.1", 255, pdu), kDenied);
  }
  EXPECT_EQ(may("192.0.2.1", 255, "2B 0E 01 00"), "permitted: there are no rules");
}

TEST_F(Who, IsRefusedByAllowAndByRulesThatDoNotKnowTheAddress) {
  settings_.listeners[0].allow = {*routing::Network::parse("192.0.2.0/24")};
  add_rule(true, "a:1");
  settings_.rules[0].clients = {{"panels", {*routing::Network::parse("192.0.2.1")}, {}}};
  EXPECT_EQ(may("192.0.3.1", 1, kRead),
            "refused by allow of listener plant: the connection is closed at once");
  EXPECT_EQ(may("192.0.2.2", 1, kRead),
            "refused by the access rules: none permits this address anything here: the connection "
            "is closed at once");
  EXPECT_EQ(may("192.0.2.1", 1, kRead), "permitted by rule a:1");
}

TEST_F(Who, IsDeniedByReadOnlyAccessFunctionsAndWindows) {
  settings_.listeners[0].read_only = {*routing::Network::parse("192.0.2.1")};
  EXPECT_EQ(may("192.0.2.1", 1, kWrite), "denied by read_only of listener plant: exception 01");
  EXPECT_EQ(may("192.0.2.1", 255, "08 000A 0000"),
            "denied by read_only of listener plant: exception 01");
  auto& route = settings_.routes[0];
  route.access = routing::Access::read_only;
  EXPECT_EQ(may("192.0.2.2", 1, kWrite), "denied by access of the route of unit 1: exception 01");
  route.access = routing::Access::read_write;
  route.functions.allowed.reset(6);
  EXPECT_EQ(may("192.0.2.2", 1, kWrite),
            "denied by functions of the route of unit 1: exception 01");
  route.functions.allowed.set(6);
  route.windows = {{modbus::Table::holding_registers, 0, 4, modbus::Table::holding_registers, 0}};
  EXPECT_EQ(may("192.0.2.2", 1, kWrite),
            "denied by the windows (registers) of the route of unit 1: exception 02");
  EXPECT_EQ(may("192.0.2.2", 250, kWrite),
            "denied by the routes: unit 250 has no route on this listener: exception 0A");
}

TEST_F(Who, IsDeniedByWhatItsDeviceOrOneOnItsBusCannotDo) {
  auto& route = settings_.routes[0];
  route.last_unit = 1;
  route.device = 0;
  settings_.routes.emplace_back().buses = {BusId{0}};  // unit 0
  settings_.devices[0].profile.functions.reset(6);
  EXPECT_EQ(may("192.0.2.1", 1, kWrite),
            "denied by the limits and values of device axis-x: exception 01");
  settings_.devices[0].profile.communication = {{modbus::Table::holding_registers, 0x10, 1}};
  EXPECT_EQ(may("192.0.2.1", 0, kWrite), "denied by the devices on the bus: exception 02");
}

TEST_F(Who, NamesTheKeyThatDenies) {
  using enum DenyingKey::Name;
  settings_.listeners.push_back(settings_.listeners[0]);
  settings_.routes.insert(settings_.routes.begin(), settings_.routes[0]);
  settings_.routes[0].listener = routing::ListenerId{1};
  auto& route = settings_.routes[1];
  route.functions.allowed.reset(6);
  may("192.0.2.1", 1, kWrite);
  EXPECT_TRUE(is_by(functions, 1));
  route.access = routing::Access::read_only;
  may("192.0.2.1", 1, kWrite);
  EXPECT_TRUE(is_by(access, 1));
  route.windows = {{modbus::Table::holding_registers, 0, 4, modbus::Table::holding_registers, 0}};
  may("192.0.2.1", 1, kRead);
  EXPECT_TRUE(is_by(windows, 1));
  settings_.listeners[0].read_only = {*routing::Network::parse("192.0.2.1")};
  may("192.0.2.1", 1, kWrite);
  EXPECT_TRUE(is_by(read_only, 0));
  settings_.listeners[0].allow = {*routing::Network::parse("192.0.2.2")};
  may("192.0.2.1", 1, kWrite);
  EXPECT_TRUE(is_by(allow, 0));
  settings_ = stop_plant();
  settings_.guards.resize(2);
  settings_.guards[1].writer = gateway::WriterRule::listed;
  may("192.0.2.1", 2, kWrite);
  EXPECT_TRUE(is_by(writer, 1));
  may("192.0.2.1", 1, kWrite);
  EXPECT_FALSE(key_);
  settings_.routes.clear();  // a transparent listener has a route that stands nowhere
  settings_.listeners[0].bus = BusId{0};
  EXPECT_EQ(may("192.0.2.1", 1, "08 0004 0000"),
            "denied by functions of the route of unit 1: exception 01");
  EXPECT_FALSE(key_);
}

TEST_F(Who, IsDeniedByTheRuleThatMatchesFirstOrByNone) {
  add_rule(false, "a:1");
  settings_.rules[0].registers.spans = {{modbus::Table::holding_registers, 16, 16}};
  add_rule(true, "a:2");
  settings_.rules[1].name = "rest";
  settings_.rules[1].units.emplace().set(1);
  settings_.rules[1].per_second = 5;
  EXPECT_EQ(may("192.0.2.1", 1, kWrite), "denied by rule a:1: exception 01");
  EXPECT_EQ(may("192.0.2.1", 1, kStop),
            "permitted by rule \"rest\" (a:2); at most 5 a second, stops excepted, else exception "
            "06");
  EXPECT_EQ(may("192.0.2.1", 2, kStop),
            "denied by the access rules: no rule permits it: exception 01");
  role_.kind = routing::ClientRole::Kind::unreadable;
  settings_.rules[1].any_role = true;
  EXPECT_EQ(may("192.0.2.1", 1, kStop),
            "denied by the access rules: the role in its certificate cannot be read: exception 01");
}

TEST_F(Who, IsDeniedByTheWriterUnlessItStops) {
  settings_.guards.resize(1);
  settings_.guards[0].writer = gateway::WriterRule::listed;
  settings_.guards[0].writers = {*routing::Network::parse("192.0.2.7")};
  EXPECT_EQ(may("192.0.2.1", 1, kWrite), "denied by writer of device axis-x: exception 01");
  EXPECT_EQ(may("192.0.2.1", 1, kStop), "permitted: there are no rules");
  EXPECT_EQ(may("192.0.2.7", 1, kWrite), "permitted: there are no rules");
}

}  // namespace
}  // namespace mbgate::test
