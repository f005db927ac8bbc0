// SPDX-License-Identifier: Apache-2.0
// Where unit 0 leads.
#include "broadcast_rig.hpp"

namespace mbgate::test {
namespace {

TEST_F(Broadcasts, ToAllBusesOfAGatewayWithoutOneLeadNowhere) {
  routes[0].buses.clear();
  EXPECT_EQ(sent("06 0001 0001"), Texts{"no resolved"});
}

TEST_F(Broadcasts, AreNotWhatUnitZeroLeadsToWhereItLeadsToOneAddress) {
  devices = {aic()};
  routes[0].first_address = 129;
  routes[0].device = 0;
  EXPECT_EQ(sent("05 000B FF00"), Texts{"no resolved"});
}

}  // namespace
}  // namespace mbgate::test
