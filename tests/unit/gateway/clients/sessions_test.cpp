// SPDX-License-Identifier: Apache-2.0
// The connections alone: numbers, turns, times.
#include "gateway/clients/sessions.hpp"

#include <gtest/gtest.h>

#include "unit/gateway/parts_plant.hpp"

namespace mbgate::test {
namespace {

class ConnectionsAlone : public testing::Test {
 protected:
  ConnectionsAlone() { settings_.listeners[0].max_connections = 2; }
  ClientSession& come(std::uint64_t client, std::string_view address, Instant now = {}) {
    return *sessions().add(ClientId{client}, info_of(address), now);
  }
  gateway::Sessions& sessions() { return sessions_ ? *sessions_ : sessions_.emplace(settings_); }

  Settings settings_ = one_bus();
  std::optional<gateway::Sessions> sessions_;
};

TEST_F(ConnectionsAlone, OneThatIsClosedIsFoundNoMoreButLiesStillUntilItIsSwept) {
  ClientSession& first = come(1, "192.0.2.1");
  come(2, "192.0.2.2");
  EXPECT_TRUE(sessions().is_full(ListenerId{0}));
  sessions().close(first);
  EXPECT_FALSE(sessions().is_full(ListenerId{0}));
  EXPECT_EQ(sessions().find(ClientId{1}), nullptr);
  EXPECT_EQ(sessions().size(), 1U);
  EXPECT_EQ(first.id(), ClientId{1});
  EXPECT_EQ(sessions().add(ClientId{1}, info_of("192.0.2.1"), {}), nullptr);
  sessions().sweep();
  EXPECT_EQ(sessions().size(), 1U);
  EXPECT_NE(sessions().find(ClientId{2}), nullptr);
  EXPECT_NE(sessions().add(ClientId{1}, info_of("192.0.2.1"), {}), nullptr);
}

TEST_F(ConnectionsAlone, OneThatIsClosedIsNotServedAnyMore) {
  ClientSession& first = come(1, "192.0.2.1");
  sessions().wake(first);
  sessions().close(first);
  EXPECT_EQ(sessions().take_ready(), nullptr);
}

TEST_F(ConnectionsAlone, ThoseOfOneAddressShareItsTurnsAndTheLastGivesThemBack) {
  ClientSession& first = come(1, "192.0.2.1");
  ClientSession& second = come(2, "192.0.2.1");
  const bus::FairnessKey shared = first.turns->key;
  EXPECT_NE(shared, bus::FairnessKey{0});
  EXPECT_EQ(second.turns, first.turns);
  EXPECT_NE(come(3, "192.0.2.2").turns->key, shared);
  sessions().close(first);
  EXPECT_EQ(second.turns->key, shared);
  sessions().close(second);
  EXPECT_EQ(come(4, "192.0.2.3").turns->key, shared);
  EXPECT_NE(come(5, "192.0.2.1").turns->key, shared);
}

TEST_F(ConnectionsAlone, AreLookedAtWhenTheirTimeHasCome) {
  settings_.listeners[0].idle_timeout = 10s;
  ClientSession& session = come(1, "192.0.2.1", Instant{1s});
  EXPECT_EQ(sessions().next_look(), Instant{11s});
  EXPECT_EQ(sessions().take_due(Instant{10s}), nullptr);
  EXPECT_EQ(sessions().take_due(Instant{11s}), &session);
  EXPECT_EQ(session.overdue(Instant{11s}), ClientSession::Overdue::idle);
  EXPECT_EQ(sessions().next_look(), std::nullopt);
  ClientSession& closed = come(2, "192.0.2.2", Instant{20s});
  EXPECT_EQ(sessions().next_look(), Instant{30s});
  sessions().close(closed);
  EXPECT_EQ(sessions().next_look(), std::nullopt);
}

}  // namespace
}  // namespace mbgate::test
