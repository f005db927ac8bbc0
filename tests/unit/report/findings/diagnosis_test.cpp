// SPDX-License-Identifier: Apache-2.0
// Troubles that need more than silence to be told apart: echoes, two devices at one address, other
// clients, another word order.
#include "unit/report/findings/trouble.hpp"

namespace mbgate::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

constexpr auto kOwnRequest = "01 03 00 00 00 01 84 0A";
constexpr auto kRequestOfAnother = "09 03 00 00 00 01 85 42";

// Its axis is asked for its word order before values are written: 133 is as configured.
Settings plant_with_order() {
  Settings settings = troubled_plant();
  auto& axis = settings.devices[0];
  axis.word_order = drive::WordOrder::little;
  axis.verify_word_order = true;
  axis.profile.values.add({modbus::Table::holding_registers, 30});
  axis.profile.word_order_register = drive::WordOrderRegister{9, {5}, {133}};
  settings.routes[0].last_unit = 1;
  settings.routes[0].device = 0;
  settings.routes[0].word_order = drive::WordOrder::big;
  return settings;
}

Settings plant_with_stop() {
  Settings settings = troubled_plant();
  settings.devices[0].profile.stops = {{.address = 0x7C, .value = 0xE1}};
  settings.devices[0].timing.stop_retries = 0;
  return settings;
}

TEST(FailedStop, IsShownWithTheExceptionUntilAWriteIsAcknowledged) {
  Trouble trouble(plant_with_stop());
  trouble.rig.receive(1, "0001 0000 0006 01 06 007C 00E1");
  trouble.rig.advance(10ms);
  trouble.rig.respond("01 86 06");
  trouble.rig.advance(5s);
  EXPECT_THAT(
      trouble.diagnoses(),
      ElementsAre("device axis: it has refused a stop | exception 0x06 (server device busy) "
                  "to the last try, 5 s ago | whether it stands still"));
  trouble.rig.receive(1, "0002 0000 0006 01 06 007C 00E1");
  trouble.rig.advance(10ms);
  trouble.rig.respond("01 06 00 7C 00 E1");
  EXPECT_THAT(trouble.diagnoses(), IsEmpty());
}

TEST(FailedStop, IsShownWhereNobodyAnswered) {
  Trouble trouble(plant_with_stop());
  trouble.ask_and_answer(1);
  trouble.rig.receive(1, "0001 0000 0006 01 06 007C 00E1");
  trouble.rig.advance(4s);
  EXPECT_THAT(
      trouble.diagnoses(),
      testing::Contains("device axis: it has not acknowledged a stop | no answer to the last "
                        "try, 3 s ago | whether it stands still"));
}

TEST(LineWithEcho, IsNamedWhereItsSettingsSayNothing) {
  Settings settings = troubled_plant();
  settings.buses[0].line.echo.reset();
  Trouble trouble(settings);
  trouble.read(kOwnRequest);
  EXPECT_THAT(
      trouble.diagnoses(),
      ElementsAre("bus line-a: the adapter receives what it sends, and `echo` does not say so | "
                  "requests come back as they were sent | set `echo = true`, or switch the "
                  "receiver off while the adapter sends; after each opening, until the echo is "
                  "found again, the answer to a write may be its echo"));
}

constexpr auto kDeniedEcho =
    "bus line-a: the adapter receives what it sends, but `echo = false` is set | requests come "
    "back as they "
    "were sent | set `echo = true`: otherwise answers are taken for those to another client, and "
    "the echo of a write for its answer";

TEST(LineWithEcho, IsNamedWhereItsSettingsDenyIt) {
  Trouble trouble;
  trouble.read(kOwnRequest);
  EXPECT_THAT(trouble.diagnoses(), IsEmpty());
  trouble.read(kOwnRequest);
  EXPECT_THAT(trouble.diagnoses(), ElementsAre(kDeniedEcho));
}

// What follows a request of another client at once is the answer to that.
TEST(LineWithEcho, ExplainsWhereItIsDeniedWhyNothingAnswers) {
  Trouble trouble;
  trouble.read_in_vain(5, "01 03 00 00 00 01 84 0A 01 03 02 12 34 B5 33");
  EXPECT_THAT(trouble.diagnoses(), ElementsAre(kDeniedEcho));
}

TEST(LineWithEcho, IsWellWhereItsSettingsSaySo) {
  Settings settings = troubled_plant();
  settings.buses[0].line.echo = true;
  Trouble trouble(settings);
  trouble.read(kOwnRequest);
  trouble.read(kOwnRequest);
  EXPECT_THAT(trouble.diagnoses(), IsEmpty());
}

// An adapter with nothing behind it.
TEST(LineWithEcho, HearsNothingButItselfWhereNobodyIs) {
  Settings settings = troubled_plant();
  settings.buses[0].line.echo.reset();
  Trouble trouble(settings);
  trouble.read_in_vain(4, kOwnRequest);
  const Lines all = trouble.diagnoses();
  ASSERT_FALSE(all.empty());
  EXPECT_THAT(all[0], StartsWith("bus line-a: nothing answers | "));
  EXPECT_THAT(all[0], testing::Not(HasSubstr("and nothing else heard")));
}

// Without an echo everything that comes differs from it.
TEST(LineWithEcho, IsDoubtedWhereNoneComes) {
  Settings settings = troubled_plant();
  settings.buses[0].line.echo = true;
  Trouble trouble(settings);
  for (int at = 0; at < 4; ++at) {
    trouble.read("");
    trouble.rig.advance(400ms);
  }
  EXPECT_THAT(
      trouble.diagnoses(),
      ElementsAre(std::string("bus line-a: nothing answers | 4 transmissions in a row to 1 "
                              "device unanswered | ") +
                  kCausesOfNoAnswer + "; `echo`: the received bytes differ from the sent ones"));
}

TEST(DeadLine, HasHeardSomethingIfBytesCame) {
  Trouble trouble;
  trouble.read_in_vain(4, "E6 18 86 9E 06");
  EXPECT_THAT(trouble.diagnoses(),
              ElementsAre(std::string("bus line-a: nothing answers | 4 transmissions in a row to 1 "
                                      "device unanswered | ") +
                          kCausesOfNoAnswer));
}

TEST(BytesWithoutAFrame, HaveAllTheirCausesNamed) {
  Trouble trouble;
  trouble.read_in_vain(5, "E6 18 86 9E 06");
  EXPECT_THAT(trouble.diagnoses(),
              ElementsAre("device axis: something answers, but no valid frame | bytes came after "
                          "each of 5 requests | baud rate, parity, A and B exchanged, two devices "
                          "at one address?"));
}

/// Bytes without a silence.
void babble(Trouble& trouble) {
  for (int at = 0; at < 1500; ++at) {
    trouble.rig.line("55");
    trouble.rig.advance(1ms);
  }
}

TEST(LineThatIsNeverSilent, IsNamedWhileItLasts) {
  Trouble trouble;
  babble(trouble);
  EXPECT_THAT(trouble.diagnoses(),
              ElementsAre("bus line-a: it is never silent: nothing can be sent | bytes came "
                          "without the silence that a request needs before it, the last 0 s ago | "
                          "another client on this line, baud rate, termination or bias"));
  trouble.rig.advance(10s);
  EXPECT_THAT(trouble.diagnoses(), IsEmpty());
}

// There may be another adapter now.
TEST(LineThatIsNeverSilent, IsNotNamedAnyMoreOnceTheLineIsOpenedAgain) {
  Trouble trouble;
  babble(trouble);
  trouble.rig.lose_line();
  trouble.rig.open_line();
  EXPECT_THAT(trouble.diagnoses(), IsEmpty());
}

TEST(AnotherClient, IsCertainWhereARequestIsHeard) {
  Trouble trouble;
  trouble.read("");
  trouble.rig.advance(20s);
  trouble.rig.line(kRequestOfAnother);
  trouble.rig.advance(5s);
  EXPECT_THAT(trouble.diagnoses(),
              ElementsAre("bus line-a: requests of another client are heard | the last one 5 s "
                          "ago, 1 counted | another client on this line (a second gateway, PLC or "
                          "tool)"));
}

TEST(AnotherClient, IsOneOfTwoCausesWhereAnAnswerIsHeard) {
  Trouble trouble;
  trouble.read("");
  trouble.rig.advance(20s);
  trouble.rig.respond(kAnswerOfAxis);
  trouble.rig.advance(5s);
  EXPECT_THAT(
      trouble.diagnoses(),
      ElementsAre("bus line-a: frames are heard that the gateway neither sent nor asked for | the "
                  "last one 5 s ago, 1 counted | another client on this line (a second "
                  "gateway, PLC or tool), or two devices at one address"));
}

TEST(TwoDevicesAtOneAddress, AreNamedForAWhileAfterTheSecondAnswer) {
  Trouble trouble;
  trouble.rig.advance(20s);
  trouble.read("");
  trouble.rig.respond(kAnswerOfAxis);
  trouble.rig.advance(3s);
  EXPECT_THAT(trouble.diagnoses(),
              ElementsAre("device axis: two answers came to one request | the last time 3 s ago | "
                          "two devices at address 1; another client on this line that asks it; "
                          "whether the adapter receives what it sends (`echo`)"));
  trouble.rig.advance(10min);
  EXPECT_THAT(trouble.diagnoses(), IsEmpty());
}

// The echo of a read is no answer.
TEST(TwoDevicesAtOneAddress, AreNamedOnALineWhoseEchoWasFound) {
  Settings settings = troubled_plant();
  settings.buses[0].line.echo.reset();
  Trouble trouble(settings);
  trouble.rig.advance(20s);
  trouble.read(kOwnRequest);
  trouble.read(kOwnRequest);
  trouble.rig.respond(kAnswerOfAxis);
  trouble.rig.advance(3s);
  EXPECT_THAT(trouble.diagnoses(),
              ElementsAre(StartsWith("device axis: two answers came to one request | the last time "
                                     "3 s ago | two devices at address 1; "),
                          StartsWith("bus line-a: the adapter receives what it sends, ")));
}

TEST(WordOrder, IsNamedWhereTheDriveHasAnother) {
  Trouble trouble(plant_with_order());
  trouble.write_value();
  trouble.tell_order("00 05");
  EXPECT_THAT(
      trouble.diagnoses(),
      ElementsAre("device axis: its word order is not the configured one | its holding register 9 "
                  "held 5 when it was last read; the configured word order has 133 | "
                  "`word_order`, or the setting of the drive; until then no values are "
                  "written to it"));
  trouble.write_value();
  trouble.tell_order("00 85");
  EXPECT_THAT(trouble.diagnoses(), IsEmpty());
}

TEST(WordOrder, IsWellOnceTheSettingsSayTheSame) {
  Settings settings = plant_with_order();
  Trouble trouble(settings);
  trouble.write_value();
  trouble.tell_order("00 05");
  settings.devices[0].word_order = drive::WordOrder::big;
  trouble.rig.reload(settings);
  EXPECT_THAT(trouble.diagnoses(), IsEmpty());
}

// It may have the right one.
TEST(WordOrder, IsNotNamedWhereTheDriveRefusesToTell) {
  Trouble trouble(plant_with_order());
  trouble.write_value();
  trouble.rig.advance(10ms);
  trouble.rig.respond("01 83 02");
  trouble.rig.advance(10ms);
  EXPECT_THAT(trouble.diagnoses(), IsEmpty());
}

}  // namespace
}  // namespace mbgate::test
