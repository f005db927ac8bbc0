// SPDX-License-Identifier: Apache-2.0
// The door of the clients alone: who is let in, who makes room, and what is left of who goes.
#include <gmock/gmock.h>

#include "gateway/clients/client_admission.hpp"
#include "unit/gateway/parts_plant.hpp"

namespace mbgate::test {
namespace {

using gateway::Phase;
using gateway::RefusalReason;
using testing::ElementsAre;
using testing::IsEmpty;

/// A listener for two clients of one network, each of which may send a request a second.
Settings narrow_plant() {
  Settings settings = stop_plant();
  settings.listeners[0].max_connections = 2;
  settings.listeners[0].max_requests_per_second = 1;
  settings.listeners[0].allow = {*routing::Network::parse("192.0.2.0/24")};
  return settings;
}

class ClientAdmissionAlone : public testing::Test {
 protected:
  void come(std::uint64_t client, std::string_view address, Phase phase = Phase::running) {
    const Instant now{std::chrono::seconds(client)};
    door_.connected(ClientId{client}, info_of(address), phase, now);
  }
  /// Whose connections are to be closed, and what is told beside that.
  std::vector<std::uint64_t> closed() {
    std::vector<std::uint64_t> clients;
    reported_.clear();
    while (const auto action = actions_.poll()) {
      if (const auto* close = std::get_if<gateway::Close>(&*action)) {
        clients.push_back(static_cast<std::uint64_t>(close->client));
      } else if (const auto* report = std::get_if<gateway::Report>(&*action)) {
        reported_.push_back(gateway::to_text(report->event, settings_.settings()));
      }
    }
    return clients;
  }
  [[nodiscard]] std::uint64_t refused(RefusalReason reason) const {
    const auto& counters = sessions_.counters(ListenerId{0});
    return counters.refused_connections.at(static_cast<std::size_t>(reason));
  }

  SettingsHistory settings_{narrow_plant()};
  ActionQueue actions_;
  gateway::Exchanges exchanges_{settings_, buses_, actions_};
  gateway::BusSet buses_{settings_.settings()};
  gateway::WriteRules rules_{settings_.in_force()};
  gateway::FailsafeWrites failsafe_{settings_, exchanges_, rules_, actions_};
  gateway::Sessions sessions_{settings_.settings()};
  gateway::ClientAdmission door_{settings_, exchanges_, failsafe_, sessions_, actions_};
  std::vector<std::string> reported_;
};

TEST_F(ClientAdmissionAlone, LetsInWhoIsAllowed) {
  come(1, "192.0.2.1");
  come(2, "10.0.0.2");
  EXPECT_THAT(closed(), ElementsAre(2));
  EXPECT_THAT(reported_,
              ElementsAre("listener plant: client 10.0.0.2 refused: not in the allow list"));
  EXPECT_NE(sessions_.find(ClientId{1}), nullptr);
  EXPECT_EQ(sessions_.size(), 1U);
  EXPECT_EQ(refused(RefusalReason::not_allowed), 1U);
}

TEST_F(ClientAdmissionAlone, LetsNobodyInWhenTheGatewayStops) {
  come(1, "192.0.2.1", Phase::only_stops);
  EXPECT_THAT(closed(), ElementsAre(1));
  EXPECT_EQ(refused(RefusalReason::stopping), 1U);
}

TEST_F(ClientAdmissionAlone, OneThatIsGoneIsNotClosedAndItsPlaceIsFree) {
  come(1, "192.0.2.1");
  come(2, "192.0.2.2");
  door_.forget(*sessions_.find(ClientId{1}), Instant{2s});
  come(3, "192.0.2.3");
  EXPECT_THAT(closed(), IsEmpty());
  EXPECT_THAT(reported_, IsEmpty());
  EXPECT_EQ(sessions_.find(ClientId{1}), nullptr);
}

TEST_F(ClientAdmissionAlone, WhoAsksTooOftenMayNotAndThatIsTold) {
  come(1, "192.0.2.1");
  ClientSession& session = *sessions_.find(ClientId{1});
  EXPECT_TRUE(door_.may_ask(session, Instant{1s}));
  EXPECT_FALSE(door_.may_ask(session, Instant{1s}));
  EXPECT_FALSE(door_.may_ask(session, Instant{1500ms}));
  EXPECT_EQ(reports<gateway::ClientOverRate>(actions_).size(), 1U);
  EXPECT_EQ(sessions_.counters(ListenerId{0}).over_rate, 2U);
  EXPECT_TRUE(door_.may_ask(session, Instant{2s}));
}

}  // namespace
}  // namespace mbgate::test
