// SPDX-License-Identifier: Apache-2.0
// How far a stop reaches: back to what lay in sockets, to every device that hears it, and no
// further than this process.
#include <gmock/gmock.h>

#include "unit/gateway/stop_plant.hpp"

namespace mbgate::test {
namespace {

using testing::ElementsAre;

TEST(Stop, TakesBackWhatLayInAPausedSocketButNotItsOwnClientsLaterWrites) {
  MachineRig rig(stop_plant());
  std::string many = read_request(0);
  for (unsigned transaction = 1; transaction < 200; ++transaction) {
    many += read_request(transaction, 250);  // no such path: answered at once
  }
  for (const std::uint64_t client : {1U, 2U}) {
    rig.connect(client);
    rig.receive(client, many);
    ASSERT_TRUE(rig.paused.contains(client));
  }
  rig.advance(10ms);
  rig.respond("01 03 02 00 01");
  rig.advance(10ms);
  rig.respond("01 03 02 00 01");
  rig.advance(10ms);
  rig.take_sent(1);
  rig.take_sent(2);
  rig.take_transmitted();
  rig.receive(1, stop_request(201) + write_request(202));
  rig.receive(2, write_request(203));
  EXPECT_THAT(rig.take_sent(2), ElementsAre(busy(203)));
  rig.respond(kStop1);
  rig.advance(10ms);
  EXPECT_THAT(take_requests(rig), ElementsAre(kStop1, kWrite1));
}

TEST(Stop, IsRefusedIfItIsOlderThanTheProcess) {
  MachineRig rig(stop_plant());
  rig.connect(1, "192.0.2.1", 0, 24);
  rig.receive(1, read_request(1) + stop_request(2) + stop_request(3));
  rig.respond("01 03 02 00 01");
  rig.advance(10ms);
  EXPECT_THAT(take_requests(rig), ElementsAre(kRead1, kStop1));
  rig.respond(kStop1);
  EXPECT_THAT(rig.take_sent(1), ElementsAre(kOne, written(3, 1, true), busy(2)));
}

TEST(Stop, OfAllCountsForEveryDeviceThatHearsIt) {
  Settings settings = stop_plant();
  settings.devices[1].profile.broadcast.form = drive::BroadcastForm::none;
  auto& route = settings.routes.emplace_back();
  route.buses = {BusId{0}};  // unit 0
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, read_request(1) + write_request(2, 1) + write_request(3, 2) + stop_request(4, 0));
  rig.respond("01 03 02 00 01");
  rig.advance(150ms);
  EXPECT_THAT(take_requests(rig), ElementsAre(kRead1, "00 06 00 7C 00 E1", kWrite2));
  EXPECT_THAT(rig.take_sent(1), ElementsAre(kOne, "00 04 00 00 00 06 00 06 00 7C 00 E1", busy(2)));
}

}  // namespace
}  // namespace mbgate::test
