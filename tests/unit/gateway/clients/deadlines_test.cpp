// SPDX-License-Identifier: Apache-2.0
// How long requests wait where no route says so.
#include <gmock/gmock.h>

#include <tuple>

#include "support/machine_rig.hpp"

namespace mbgate::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr auto kDeadlineRead = "0007 0000 0006 01  03 001E 0002";
constexpr auto kDeadlineWrite = "0008 0000 0006 01  06 007C 00E1";

// 264 characters at 19200 take 151.25 ms.
TEST(Deadlines, WritesWaitTwoTransactionsAndALittleReadsNoLess) {
  for (const auto& [timeout, write, read] :
       {std::tuple{1s, 2802500us, 5000000us}, std::tuple{3s, 6802500us, 6802500us}}) {
    Settings settings = one_bus();
    settings.buses[0].timing.response_timeout = timeout;
    MachineRig rig(settings, false);  // the line is not there yet
    rig.connect(1);
    rig.receive(1, kDeadlineWrite);
    rig.connect(2);
    rig.receive(2, kDeadlineRead);
    rig.advance(write - 1us);
    EXPECT_THAT(rig.take_sent(1), IsEmpty());
    rig.advance(1us);
    EXPECT_THAT(rig.take_sent(1), ElementsAre("00 08 00 00 00 03 01 86 06"));
    rig.advance(std::max<Duration>(read - write - 1us, 0us));
    EXPECT_EQ(rig.take_sent(2).size(), read == write ? 1U : 0U);
    rig.advance(1us);
    EXPECT_EQ(rig.take_sent(2).size(), read == write ? 0U : 1U);
  }
}

TEST(Deadlines, CountFromTheFirstByteOfARequest) {
  Settings settings = one_bus();
  settings.buses[0].timing.response_timeout = 1s;
  MachineRig rig(settings, false);
  rig.connect(1);
  rig.receive(1, "00");
  rig.advance(1s);
  rig.receive(1, "08 0000 0006 01  06 007C 00E1");
  rig.advance(1802ms);  // of 2802.5 ms
  EXPECT_THAT(rig.take_sent(1), IsEmpty());
  rig.advance(1ms);
  EXPECT_EQ(rig.take_sent(1).size(), 1U);
}

// A process that was stopped: what is read then has come at any time since.
TEST(Deadlines, CountFromTheBeginningOfAStallUntilASocketWasSeenEmpty) {
  MachineRig rig;
  for (const std::uint64_t client : {1, 2, 3}) {
    rig.connect(client);
  }
  rig.advance(10s);
  rig.harness.handle(gateway::Stalled{9s});
  rig.receive(1, kDeadlineWrite, 12);
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 08 00 00 00 03 01 86 06"));
  rig.receive(1, kDeadlineWrite);  // the 12 bytes that lay behind it
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 08 00 00 00 03 01 86 06"));
  rig.receive(2, "");  // nothing lay there
  EXPECT_THAT(rig.take_transmitted(), IsEmpty());
  rig.receive(2, kDeadlineWrite);
  EXPECT_EQ(rig.take_transmitted().size(), 1U);
  rig.half_close(3);  // it was read to its end
  EXPECT_THAT(rig.closed, ElementsAre(3));
}

// What would have ended them may lie in a socket that nobody has read.
TEST(Deadlines, OfIncompleteRequestsAndIdleClientsAreJudgedAfterAStallWhenTheSocketWasRead) {
  Settings settings = one_bus();
  settings.listeners[0].idle_timeout = 10s;
  MachineRig rig(settings);
  for (const std::uint64_t client : {1, 2, 3}) {
    rig.connect(client);
  }
  rig.receive(1, "0001 0000");
  rig.receive(2, "0001 0000");
  rig.harness.go_on(rig.harness.now() + 20s);  // nobody wakes it
  rig.harness.handle(gateway::Stalled{20s});
  rig.advance(0ms);
  EXPECT_THAT(rig.closed, IsEmpty());
  rig.receive(1, "0006 FA 03 0000 0001");
  rig.receive(2, "");
  rig.receive(3, "");
  rig.advance(0ms);
  EXPECT_THAT(rig.closed, ElementsAre(2, 3));
}

// It is not late then, only older.
TEST(Deadlines, LeaveTheRestOfTheirTimeToWhatIsReadAfterAShortStall) {
  MachineRig rig(one_bus(), false);
  rig.connect(1);
  rig.advance(10s);
  rig.harness.handle(gateway::Stalled{600ms});
  rig.receive(1, kDeadlineWrite);
  rig.advance(402ms);  // of 1002.5 ms
  EXPECT_THAT(rig.take_sent(1), IsEmpty());
  rig.advance(1ms);
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 08 00 00 00 03 01 86 06"));
}

}  // namespace
}  // namespace mbgate::test
