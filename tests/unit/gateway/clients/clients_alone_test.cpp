// SPDX-License-Identifier: Apache-2.0
// Connections, with the parts that they need but without the gateway.
#include <gmock/gmock.h>

#include "gateway/clients/clients.hpp"
#include "unit/gateway/parts_plant.hpp"

namespace mbgate::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

class ClientsAlone : public testing::Test {
 protected:
  ClientsAlone() { buses_.touch(BusId{0}).handle_opened(now_, bus::LineKind::virtual_line); }
  void receive(std::string_view bytes) {
    const auto octets = unhex(bytes);
    clients_.handle(gateway::ClientBytes{ClientId{1}, octets}, now_);
    while (clients_.serve_one(now_)) {
    }
  }
  Lines sent() {
    Lines sent;
    while (const auto action = actions_.poll()) {
      if (const auto* send = std::get_if<gateway::Send>(&*action)) {
        sent.push_back(hex({send->adu.data(), send->adu.size()}));
      }
    }
    return sent;
  }

  gateway::Instant now_{1s};
  SettingsHistory settings_{stop_plant(2)};
  ActionQueue actions_;
  gateway::BusSet buses_{settings_.settings()};
  gateway::Exchanges exchanges_{settings_, buses_, actions_};
  gateway::WriteRules rules_{settings_.in_force()};
  gateway::FailsafeWrites failsafe_{settings_, exchanges_, rules_, actions_};
  gateway::TraceBook trace_{settings_};
  gateway::Clients clients_{settings_, buses_, exchanges_, rules_,
                            failsafe_, trace_, actions_,   now_};
};

TEST_F(ClientsAlone, AnswerWhatNeedsNoBus) {
  clients_.handle(gateway::ClientConnected{ClientId{1}, info_of("192.0.2.1")}, now_);
  receive("0001 0000 0006 FA 03 0000 0001");
  EXPECT_THAT(sent(), ElementsAre("00 01 00 00 00 03 FA 83 0A"));
  EXPECT_EQ(clients_.counters().requests, 1U);
}

TEST_F(ClientsAlone, AreNotLetInWhenTheGatewayStops) {
  clients_.set_phase(gateway::Phase::only_stops);
  clients_.handle(gateway::ClientConnected{ClientId{1}, info_of("192.0.2.1")}, now_);
  EXPECT_EQ(clients_.sessions().size(), 0U);
  const auto refused = reports<gateway::ClientRefused>(actions_);
  ASSERT_THAT(refused, testing::SizeIs(1));
  EXPECT_EQ(refused[0].reason, gateway::RefusalReason::stopping);
}

TEST_F(ClientsAlone, AreAnsweredWhenTheJobsOfTheirRequestHaveEnded) {
  clients_.handle(gateway::ClientConnected{ClientId{1}, info_of("192.0.2.1")}, now_);
  receive("0001 0000 0006 01 03 0000 0001");
  bus::Job& job = *exchanges_[0].parts.front().job;
  buses_.touch(BusId{0}).withdraw(job);
  exchanges_.end(job, bus::Ending::no_answer);
  clients_.complete(*exchanges_.take_completed(), now_);
  EXPECT_THAT(sent(), ElementsAre("00 01 00 00 00 03 01 83 06")) << "nothing was transmitted";
}

TEST_F(ClientsAlone, GetNothingOnceTheyAreGone) {
  clients_.handle(gateway::ClientConnected{ClientId{1}, info_of("192.0.2.1")}, now_);
  receive("0001 0000 0006 01 03 0000 0001");
  clients_.handle(gateway::ClientDisconnected{ClientId{1}}, now_);
  EXPECT_EQ(clients_.sessions().size(), 0U);
  clients_.sweep();
  if (const auto index = exchanges_.take_completed()) {
    clients_.complete(*index, now_);
  }
  EXPECT_THAT(sent(), IsEmpty());
}

}  // namespace
}  // namespace mbgate::test
