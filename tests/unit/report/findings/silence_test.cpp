// SPDX-License-Identifier: Apache-2.0
// Drives and lines that say nothing: which of them, since when, and why that may be.
#include "unit/report/findings/trouble.hpp"

namespace mbgate::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::StartsWith;

TEST(SilentDrive, IsNotBesideOthersThatAnsweredOnlyBefore) {
  Trouble trouble;
  trouble.ask_and_answer(2);
  trouble.ask_in_vain(3, 1);
  EXPECT_THAT(
      trouble.diagnoses(),
      ElementsAre("device axis: it has never answered | 3 transmissions in a row unanswered | "
                  "its power; its address 1; its baud rate and parity, here 19200 baud 8E1; "
                  "its wires"));
}

TEST(AddressWithoutADevice, MayBeAMistakeOfTheClient) {
  Trouble trouble;
  trouble.ask_in_vain(1, 9);
  trouble.ask_and_answer(1);
  trouble.ask_in_vain(2, 9);
  EXPECT_THAT(trouble.diagnoses(),
              ElementsAre("bus line-a address 9: it has never answered | 3 transmissions in a row "
                          "unanswered; others on line-a answer | the unit identifier that the "
                          "client asks for; its power; its address 9; its baud rate and parity, "
                          "here 19200 baud 8E1; its wires"));
}

TEST(AddressWithoutADevice, SharesALineWithTheOthersThatAClientTries) {
  Trouble trouble;
  for (unsigned unit = 3; unit <= 12; ++unit) {
    trouble.ask_in_vain(3, unit);
  }
  trouble.ask_in_vain(3, 20);
  trouble.ask_and_answer(1);
  EXPECT_THAT(trouble.diagnoses(),
              ElementsAre("bus line-a: 11 addresses have never answered | 3 to 12, 20; others on "
                          "line-a answer | the unit identifiers that a client asks for; if drives "
                          "should be there: their power, addresses, wires and settings"));
}

TEST(AddressWithoutADevice, IsForgottenWhenNobodyAsksItAnyMore) {
  Trouble trouble;
  trouble.ask_and_answer(1);
  trouble.ask_in_vain(3, 9);
  EXPECT_THAT(trouble.diagnoses(),
              ElementsAre(StartsWith("bus line-a address 9: it has never answered")));
  for (int at = 0; at < 3; ++at) {
    EXPECT_THAT(trouble.diagnoses(), testing::SizeIs(1));
    trouble.rig.advance(1min);
    trouble.ask_and_answer(1);
  }
  EXPECT_THAT(trouble.diagnoses(), IsEmpty());
}

TEST(SilentDrive, IsAWarningOnceNobodyAsksIt) {
  Trouble trouble;
  trouble.ask_and_answer(1);
  trouble.ask_in_vain(3, 1);
  trouble.rig.advance(3h);
  EXPECT_THAT(trouble.diagnoses(),
              ElementsAre("device axis: it did not answer when it was last asked | that "
                          "was 3 h ago | whether it should be asked; its power, its "
                          "cable"));
}

TEST(Diagnoses, NameTheWorstFirst) {
  Trouble trouble;
  trouble.ask_and_answer(2);
  trouble.rig.advance(20s);
  trouble.rig.line("09 03 00 00 00 01 85 42");
  trouble.rig.advance(400ms);
  trouble.ask_in_vain(3, 1);
  EXPECT_THAT(trouble.diagnoses(),
              ElementsAre(StartsWith("device axis: it has never answered"),
                          StartsWith("bus line-a: requests of another client are heard")));
}

TEST(DeadLine, HasHeardSomethingThoughCountersWereCleared) {
  Trouble trouble;
  trouble.read_in_vain(4, "E6 18 86 9E 06");
  trouble.rig.clear_counters();
  EXPECT_THAT(trouble.diagnoses(),
              ElementsAre(std::string("bus line-a: nothing answers | 4 transmissions in a row to 1 "
                                      "device unanswered | ") +
                          kCausesOfNoAnswer));
}

TEST(DeadLine, IsNotHiddenByADriveThatIsSeldomAsked) {
  Settings settings = troubled_plant();
  settings.devices.push_back({"pump", BusId{0}, 3, settings.buses[0].timing});
  Trouble trouble(settings);
  for (const unsigned unit : {1U, 2U, 3U}) {
    trouble.ask_and_answer(unit);
  }
  trouble.rig.advance(1min);
  trouble.ask_in_vain(3, 1);
  trouble.ask_in_vain(3, 2);
  EXPECT_THAT(
      trouble.diagnoses(),
      ElementsAre("bus line-a: nothing answers any more | 6 transmissions in a row to 2 devices "
                  "unanswered, and nothing else heard | the plug and the cable of the line; "
                  "the power of the drives"));
}

TEST(DeadLine, IsNoneWhereAClientTriesAddressesBesideADriveThatIsSeldomAsked) {
  Trouble trouble;
  trouble.ask_and_answer(1);
  trouble.rig.advance(11min);
  trouble.ask_in_vain(3, 8);
  trouble.ask_in_vain(3, 9);
  EXPECT_THAT(trouble.diagnoses(),
              ElementsAre("bus line-a: 2 addresses have never answered | 8 to 9 | the unit "
                          "identifiers that a client asks for; if drives should be there: their "
                          "power, addresses, wires and settings"));
}

TEST(DeadLine, HasOtherCausesBehindASerialDeviceServer) {
  Settings settings = troubled_plant();
  settings.buses[0].line.remote = bus::Endpoint{"192.0.2.1", 4001};
  Trouble trouble(settings);
  trouble.ask_in_vain(3, 1);
  trouble.rig.advance(2s);
  EXPECT_THAT(
      trouble.diagnoses(),
      ElementsAre("bus line-a: nothing answers | 3 transmissions in a row to 1 device "
                  "unanswered, and nothing else heard | power of the drives; A and B at the "
                  "serial server; rate and parity, which are set there; whether it passes "
                  "raw bytes, or speaks Modbus TCP (`mode`); unit addresses"));
}

TEST(HungAdapter, IsNotLostWhileTheGatewayReopensIt) {
  Settings settings = troubled_plant();
  settings.buses[0].hung_requests = 3;
  Trouble trouble(settings);
  trouble.rig.lose_line();
  trouble.rig.harness.handle(gateway::LineOpened{BusId{0}, bus::LineKind::uart});
  trouble.rig.advance(5ms);
  trouble.ask_in_vain(3, 1);
  trouble.rig.advance(60s);
  trouble.rig.opened.clear();
  trouble.ask_in_vain(1, 1);
  ASSERT_THAT(trouble.rig.opened, testing::SizeIs(1));
  EXPECT_THAT(trouble.diagnoses(), ElementsAre(StartsWith("bus line-a: nothing answers | ")));
}

}  // namespace
}  // namespace mbgate::test
