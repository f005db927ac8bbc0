// SPDX-License-Identifier: Apache-2.0
// Who makes room on a listener that is full.
#include <gmock/gmock.h>

#include "unit/gateway/writes/stop_plant.hpp"

namespace mbgate::test::room_test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr auto kPlc = "192.0.2.1";
constexpr auto kScreen = "192.0.2.2";
constexpr auto kOther = "192.0.2.3";

class Room : public testing::Test {
 protected:
  void open(std::size_t max_connections, std::string_view kept = {}) {
    Settings settings = one_bus();
    settings.listeners[0].max_connections = max_connections;
    if (!kept.empty()) {
      settings.listeners[0].keep = {*routing::Network::parse(kept)};
    }
    rig_.emplace(settings);
  }
  void come(std::uint64_t client, const std::string& address) {
    rig_->connect(client, address);
    rig_->advance(1s);
  }
  /// It has asked something, and has its answer.
  void ask(std::uint64_t client) {
    rig_->receive(client, read_request(1, 250));
    rig_->advance(1s);
  }
  /// It waits for an answer.
  void keep_busy(std::uint64_t client) { rig_->receive(client, read_request(1)); }

  std::optional<MachineRig> rig_;
};

// 31 silent connections beside a PLC that is idle between two polls.
TEST_F(Room, AClientWithOneConnectionKeepsItBesideOneWithMany) {
  open(4);
  come(1, kPlc);
  ask(1);
  for (std::uint64_t client = 2; client < 12; ++client) {
    come(client, kOther);
  }
  EXPECT_THAT(rig_->closed, ElementsAre(2, 3, 4, 5, 6, 7, 8));
  come(12, kScreen);
  EXPECT_THAT(rig_->closed, ElementsAre(2, 3, 4, 5, 6, 7, 8, 9));
  const auto status = rig_->harness.gateway().report_status(0s, rig_->now());
  EXPECT_EQ(status.listeners[0].counters.displaced_full, 8U);
  EXPECT_EQ(
      rig_->events.back(),
      "listener plant: client 192.0.2.3 closed for a newcomer: max_connections (4) is reached, "
      "and it had the most connections or had never asked anything");
}

TEST_F(Room, OfTheNewcomerIfItHasAsManyAsAnother) {
  open(4);
  come(1, kPlc);
  come(2, kPlc);
  come(3, kOther);
  come(4, kScreen);
  come(5, kOther);  // two of each, with this one
  EXPECT_THAT(rig_->closed, ElementsAre(3));
}

TEST_F(Room, OneThatNeverAskedGoesBeforeOneThatHas) {
  open(3);
  come(1, kOther);
  ask(1);
  come(2, kOther);
  come(3, kScreen);
  come(4, kPlc);
  EXPECT_THAT(rig_->closed, ElementsAre(2));
}

TEST_F(Room, ThenTheLongestIdleGoes) {
  open(3);
  come(1, kOther);
  come(2, kOther);
  come(3, kOther);
  ask(2);
  ask(3);
  ask(1);
  come(4, kPlc);
  EXPECT_THAT(rig_->closed, ElementsAre(2));
}

TEST_F(Room, IfAllHaveWorkTheOldestGoes) {
  open(2);
  come(1, kOther);
  come(2, kOther);
  keep_busy(2);
  keep_busy(1);
  come(3, kPlc);
  EXPECT_THAT(rig_->closed, ElementsAre(1));
}

TEST_F(Room, WhereEachClientHasOneOnlyOneThatNeverAskedGoes) {
  open(2);
  come(1, kPlc);
  ask(1);
  come(2, kOther);
  come(3, kScreen);
  EXPECT_THAT(rig_->closed, ElementsAre(2));
  ask(3);
  come(4, kOther);
  EXPECT_THAT(rig_->closed, ElementsAre(2, 4));
  EXPECT_EQ(rig_->events.back(),
            "listener plant: client 192.0.2.3 refused: max_connections is reached, and every other "
            "client uses its only connection or is in the keep list");
}

TEST_F(Room, KeptClientsNeverGo) {
  open(2, kPlc);
  come(1, kPlc);
  come(2, kPlc);
  come(3, kOther);
  EXPECT_THAT(rig_->closed, ElementsAre(3));
}

TEST_F(Room, AddressesOfOneIpv6NetworkAreOneClient) {
  open(3);
  come(1, "2001:db8::1");
  ask(1);
  come(2, "2001:db8:0:1::1");
  come(3, "2001:db8:0:1::2");
  come(4, "2001:db8:0:1::3");
  EXPECT_THAT(rig_->closed, ElementsAre(2));
}

TEST_F(Room, WhereCertificatesAreCountedEachIsAClient) {
  Settings settings = one_bus();
  settings.listeners[0].max_connections = 3;
  settings.listeners[0].counts_certificates = true;
  rig_.emplace(settings);
  const auto named = [](const char* name) {
    return routing::ClientRole{routing::ClientRole::Kind::named, "operator", name};
  };
  rig_->connect(1, kPlc, 0, {}, named("plc"));
  ask(1);
  rig_->connect(2, kPlc, 0, {}, named("screen"));
  rig_->connect(3, kOther, 0, {}, named("screen"));
  rig_->connect(4, kOther, 0, {}, named("plc 2"));
  EXPECT_THAT(rig_->closed, ElementsAre(2));
}

TEST_F(Room, ARoleMayBeKept) {
  Settings settings = one_bus();
  settings.listeners[0].max_connections = 2;
  settings.listeners[0].keep.roles = {"plc"};
  rig_.emplace(settings);
  rig_->connect(1, kPlc, 0, {}, {routing::ClientRole::Kind::named, "plc", {}});
  rig_->connect(2, kPlc, 0, {}, {routing::ClientRole::Kind::named, "screen", {}});
  rig_->connect(3, kPlc, 0, {}, {routing::ClientRole::Kind::named, "plc", {}});
  EXPECT_THAT(rig_->closed, ElementsAre(2));
}

}  // namespace
}  // namespace mbgate::test::room_test
