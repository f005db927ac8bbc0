// SPDX-License-Identifier: Apache-2.0
// What the status report has for those who collect metrics.
#include "unit/gateway/status/trouble.hpp"

namespace mbgate::test {
namespace {

// 8 characters at 19200 baud and the timeout of 100 ms: what comes after 200 ms is some 95 ms late.
// A quarter more is covered.
TEST(CollectedReport, TellsAQuarantineThatLateAnswersHaveLengthened) {
  Trouble plant;
  const auto axis = [&] {
    return plant.rig.harness.gateway().report_status(60s, plant.rig.now()).devices.at(0);
  };
  EXPECT_EQ(axis().quarantine, Duration{100ms});
  EXPECT_EQ(axis().least_quarantine, Duration{100ms});
  plant.rig.receive(1, read_request(1, 1));
  plant.rig.advance(200ms);
  plant.rig.respond(kAnswerOfAxis);
  plant.rig.advance(30ms);
  EXPECT_GT(axis().quarantine, Duration{100ms});
  EXPECT_EQ(axis().least_quarantine, Duration{100ms});
}

}  // namespace
}  // namespace mbgate::test
