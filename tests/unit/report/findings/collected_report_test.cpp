// SPDX-License-Identifier: Apache-2.0
// What the status report has for those who collect metrics.
#include "unit/report/findings/trouble.hpp"

namespace mbgate::test {
namespace {

// 8 characters at 19200 baud and the timeout of 100 ms: what comes after 200 ms is some 95 ms late.
// A quarter more is covered.
TEST(CollectedReport, TellsAQuarantineThatLateAnswersHaveLengthened) {
  Trouble plant;
  const auto axis = [&] { return plant.report().devices.at(0); };
  EXPECT_EQ(axis().quarantine, Duration{100ms});
  EXPECT_EQ(axis().least_quarantine, Duration{100ms});
  plant.rig.receive(1, read_request(1, 1));
  plant.rig.advance(200ms);
  plant.rig.respond(kAnswerOfAxis);
  plant.rig.advance(30ms);
  EXPECT_GT(axis().quarantine, Duration{100ms});
  EXPECT_EQ(axis().least_quarantine, Duration{100ms});
}

TEST(CollectedReport, HasClientsOnlyIfTheyAreAskedFor) {
  Trouble plant;
  EXPECT_EQ(plant.report(true).clients.size(), 1U);
  EXPECT_EQ(plant.report(false).clients.size(), 0U);
  EXPECT_EQ(plant.report(false).listeners.at(0).connections, 1U);
}

TEST(CollectedReport, SaysWhoWaitsWhereSomebodyDoes) {
  Trouble plant;
  EXPECT_FALSE(plant.report().buses.at(0).most_waiting);
  plant.rig.receive(1, read_request(1, 1));
  plant.rig.receive(1, read_request(2, 2));
  const auto most = plant.report().buses.at(0).most_waiting;
  ASSERT_TRUE(most);
  EXPECT_EQ(most->address, "192.0.2.7");
  EXPECT_EQ(most->requests, 1U);
  EXPECT_FALSE(most->others_ask);
  plant.rig.connect(2, "192.0.2.8");
  EXPECT_FALSE(plant.report().buses.at(0).most_waiting->others_ask);
  plant.rig.receive(2, read_request(1, 2));
  EXPECT_TRUE(plant.report().buses.at(0).most_waiting->others_ask);
}

}  // namespace
}  // namespace mbgate::test
