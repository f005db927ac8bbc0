// SPDX-License-Identifier: Apache-2.0
// One request, one answer: what the client gets for what it asked.
#include <gmock/gmock.h>

#include "support/machine_rig.hpp"

namespace mbgate::test::requests_test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

// transaction 0007, unit 1: read holding registers 30..31 (moons-drives.txt, section 7.1).
constexpr auto kRead = "0007 0000 0006 01  03 001E 0002";
constexpr auto kReadFrame = "01 03 00 1E 00 02 A4 0D";
constexpr auto kReadAnswer = "01 03 04 00 03 0D 40";
constexpr auto kReadAnswerAdu = "00 07 00 00 00 07 01 03 04 00 03 0D 40";
// write single register 124 = 0x00E1 (stop).
constexpr auto kWrite = "0008 0000 0006 01  06 007C 00E1";
constexpr auto kWriteFrame = "01 06 00 7C 00 E1 88 5A";

TEST(Gateway, CarriesARequestToTheLineAndItsAnswerBack) {
  MachineRig rig;
  rig.connect(1);
  rig.receive(1, kRead);
  EXPECT_THAT(rig.take_transmitted(), ElementsAre(kReadFrame));
  rig.advance(10ms);
  rig.respond(kReadAnswer);
  EXPECT_THAT(rig.take_sent(1), ElementsAre(kReadAnswerAdu));
}

TEST(Gateway, PassesExceptionsOfTheDeviceOnAtOnce) {
  MachineRig rig;
  rig.connect(1);
  rig.receive(1, kRead);
  rig.respond("01 83 11");  // MOONS': register does not support read
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 07 00 00 00 03 01 83 11"));
}

TEST(Gateway, AnswersSplitAndCoalescedRequestsAlike) {
  const auto whole = unhex("0001 0000 0006 01 03 0000 0001  0002 0000 0006 02 03 0000 0001");
  for (std::size_t cut = 1; cut < whole.size(); ++cut) {
    MachineRig rig;
    rig.connect(1);
    rig.receive(1, hex(modbus::Bytes(whole).first(cut)));
    rig.receive(1, hex(modbus::Bytes(whole).subspan(cut)));
    rig.respond("01 03 02 12 34");
    rig.advance(10ms);
    rig.respond("02 03 02 56 78");
    EXPECT_THAT(rig.take_sent(1),
                ElementsAre("00 01 00 00 00 05 01 03 02 12 34", "00 02 00 00 00 05 02 03 02 56 78"))
        << "cut at " << cut;
  }
}

TEST(Gateway, GivesAReadOfASilentDevice0BAfterItsRetries) {
  MachineRig rig;
  rig.connect(1);
  rig.receive(1, kRead);
  rig.advance(90ms);
  EXPECT_EQ(rig.take_transmitted().size(), 1U);
  // 8 characters of 11 bits at 19200 take 4.583 ms; twice 100 ms + that + t3.5 is under 214 ms.
  rig.advance(125ms);
  EXPECT_THAT(rig.take_transmitted(), ElementsAre(kReadFrame));
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 07 00 00 00 03 01 83 0B"));
  rig.advance(10s);
  EXPECT_THAT(rig.take_transmitted(), IsEmpty());
}

TEST(Gateway, TransmitsAWriteToASilentDeviceOnce) {
  MachineRig rig;
  rig.connect(1);
  rig.receive(1, kWrite);
  rig.advance(10s);
  EXPECT_THAT(rig.take_transmitted(), ElementsAre(kWriteFrame));
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 08 00 00 00 03 01 86 0B"));
}

/// What becomes of kWrite on this bus if the device keeps silent, and says that it may be repeated.
Lines written_to_silent(Settings settings, const drive::DeviceTiming& timing) {
  drive::Device device{"axis", BusId{0}, 1, {}};
  device.timing = timing;
  device.timing.retry_writes = true;
  settings.devices = {device};
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, kWrite);
  rig.advance(10s);
  return rig.take_transmitted();
}

TEST(Gateway, RepeatsWritesOnlyOfDevicesThatSayItIsSafe) {
  EXPECT_THAT(written_to_silent(one_bus(), {.response_timeout = 50ms}),
              ElementsAre(kWriteFrame, kWriteFrame));
}

TEST(Gateway, RepeatsWritesWithAllOtherTimesAsTheyAre) {
  Settings settings = one_bus();
  settings.buses[0].timing = {};
  EXPECT_THAT(written_to_silent(settings, {}), ElementsAre(kWriteFrame, kWriteFrame));
}

TEST(Gateway, RefusesWhatCannotBeOrMayNotBe) {
  Settings settings = one_bus();
  settings.routes[0].last_unit = 100;
  settings.routes[0].functions.allowed.reset(0x10);
  MachineRig rig(settings);
  rig.connect(1);
  const auto answer_to = [&](std::string_view request) {
    rig.receive(1, request);
    const auto sent = rig.take_sent(1);
    return sent.size() == 1 ? sent[0] : "nothing or too much";
  };
  // no route
  EXPECT_EQ(answer_to("0001 0000 0006 65 03 0000 0001"), "00 01 00 00 00 03 65 83 0A");
  // functions 0 and 128 and above
  EXPECT_EQ(answer_to("0002 0000 0002 01 00"), "00 02 00 00 00 03 01 80 01");
  EXPECT_EQ(answer_to("0003 0000 0002 01 90"), "00 03 00 00 00 03 01 90 01");
  // a function that the route denies
  EXPECT_EQ(answer_to("0004 0000 0009 01 10 0000 0001 02 0001"), "00 04 00 00 00 03 01 90 01");
  // cut short, quantity 0, quantity over the limit, a coil that is neither on nor off
  EXPECT_EQ(answer_to("0005 0000 0005 01 03 0000 00"), "00 05 00 00 00 03 01 83 03");
  EXPECT_EQ(answer_to("0006 0000 0006 01 03 0000 0000"), "00 06 00 00 00 03 01 83 03");
  EXPECT_EQ(answer_to("0007 0000 0006 01 03 0000 007E"), "00 07 00 00 00 03 01 83 03");
  EXPECT_EQ(answer_to("0008 0000 0006 01 05 0000 1234"), "00 08 00 00 00 03 01 85 03");
  // beyond address 65535
  EXPECT_EQ(answer_to("0009 0000 0006 01 03 FFFF 0002"), "00 09 00 00 00 03 01 83 02");
  // sub-functions that silence a device pass only where they are named
  EXPECT_EQ(answer_to("000A 0000 0006 01 08 0004 0000"), "00 0A 00 00 00 03 01 88 01");
  EXPECT_THAT(rig.take_transmitted(), IsEmpty());
}

TEST(Gateway, LetsReadOnlyClientsReadOnly) {
  Settings settings = one_bus();
  settings.listeners[0].read_only = {*routing::Network::parse("192.0.2.0/24")};
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, kWrite);
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 08 00 00 00 03 01 86 01"));
  rig.receive(1, kRead);
  EXPECT_THAT(rig.take_transmitted(), ElementsAre(kReadFrame));
}

TEST(Gateway, RewritesAddressesThroughAWindowAndBack) {
  Settings settings = one_bus();
  settings.routes[0].first_unit = settings.routes[0].last_unit = 11;
  settings.routes[0].functions = routing::FunctionRules::rewritable();
  settings.routes[0].windows = {
      {modbus::Table::holding_registers, 1000, 600, modbus::Table::holding_registers, 0}};
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, "0001 0000 0006 0B 06 0464 00E1");  // client register 1124 is device register 124
  EXPECT_THAT(rig.take_transmitted(), ElementsAre(kWriteFrame));
  rig.respond("01 06 00 7C 00 E1");
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 01 00 00 00 06 0B 06 04 64 00 E1"));
  for (const auto* outside : {"0002 0000 0006 0B 03 03E7 0001", "0002 0000 0006 0B 03 063F 0002",
                              "0002 0000 0006 0B 04 03E8 0001"}) {
    rig.receive(1, outside);
    EXPECT_THAT(rig.take_sent(1), ElementsAre(testing::EndsWith(" 02"))) << outside;
  }
  rig.receive(1, "0003 0000 0002 0B 11");  // report server id cannot be rewritten
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 03 00 00 00 03 0B 91 01"));
  EXPECT_THAT(rig.take_transmitted(), IsEmpty());
}

// One transaction for each register.
TEST(Gateway, TakesRequestsOfAConnectionWhileFewerThan256OfTheirTransactionsAreOpen) {
  Settings settings = one_bus();
  drive::Device& device = settings.devices.emplace_back();
  device.name = "axis-x";
  device.timing = settings.buses[0].timing;
  device.profile.limits.read[2] = 1;
  settings.routes[0].last_unit = 1;
  settings.routes[0].device = 0;
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, "0001 0000 0006 01 03 0000 007D 0002 0000 0006 01 03 0000 007D");
  rig.receive(1, "0003 0000 0006 01 03 0000 0005 0004 0000 0006 01 03 0000 0001");
  EXPECT_THAT(rig.take_sent(1), IsEmpty());
  rig.receive(1, "0005 0000 0006 01 03 0000 0001");
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 05 00 00 00 03 01 83 06"));
}

TEST(Gateway, RestartAndListenOnlyAreAllowedEachByItself) {
  constexpr auto kRestart = "0001 0000 0006 01 08 0001 0000";
  constexpr auto kListenOnly = "0001 0000 0006 01 08 0004 0000";
  Settings settings = one_bus();
  for (const bool is_restart : {true, false}) {
    settings.routes[0].functions.restart_communications = is_restart;
    settings.routes[0].functions.force_listen_only = !is_restart;
    MachineRig rig(settings);
    rig.connect(1);
    rig.receive(1, is_restart ? kListenOnly : kRestart);
    EXPECT_THAT(rig.take_sent(1), ElementsAre("00 01 00 00 00 03 01 88 01"));
    rig.receive(1, is_restart ? kRestart : kListenOnly);
    EXPECT_THAT(rig.take_transmitted(), testing::SizeIs(1));
  }
}

TEST(Gateway, AnotherDelimiterIsSetOnAsciiLinesOnlyWhereItIsNamed) {
  constexpr auto kDelimiter = "0001 0000 0006 01 08 0003 3B00";
  Settings settings = one_bus();
  settings.listeners.emplace_back().name = "service";
  settings.listeners[1].bus = BusId{0};
  for (const bool is_ascii : {false, true}) {
    settings.buses[0].line.framing = is_ascii ? bus::Framing::ascii : bus::Framing::rtu;
    settings.routes[0].functions.change_delimiter = !is_ascii;
    for (const std::uint32_t listener : {0U, 1U}) {
      MachineRig rig(settings);
      rig.connect(1, "192.0.2.1", listener);
      rig.receive(1, kDelimiter);
      EXPECT_EQ(rig.take_sent(1), is_ascii ? Lines{"00 01 00 00 00 03 01 88 01"} : Lines{});
      EXPECT_EQ(rig.take_transmitted().size(), is_ascii ? 0U : 1U);
    }
  }
}

TEST(Gateway, SilenceAfterListenOnlyIsNoFailure) {
  Settings settings = one_bus();
  settings.routes[0].functions.force_listen_only = true;
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, "0001 0000 0006 01 08 0004 0000");
  rig.advance(110ms);
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 01 00 00 00 06 01 08 00 04 00 00"));
}

// Nobody but the drive knows the values that 23 asks for.
TEST(Gateway, AnswersAWriteThatIsNeverAnsweredUnlessItReadsToo) {
  Settings settings = one_bus();
  settings.devices = {{"axis-x", BusId{0}, 1, settings.buses[0].timing}};
  settings.routes[0].last_unit = 1;
  settings.routes[0].device = 0;
  settings.devices[0].profile.unanswered = {{{.address = 5, .mask = 0, .value = 0}, 10ms}};
  settings.routes[0].functions_named = true;
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, "0001 0000 0006 01 06 0005 0001");
  rig.advance(200ms);
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 01 00 00 00 06 01 06 00 05 00 01"));
  rig.receive(1, "0002 0000 000D 01 17 0401 0002 0005 0001 02 0001");
  rig.advance(200ms);
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 02 00 00 00 03 01 97 0B"));
}

}  // namespace
}  // namespace mbgate::test::requests_test
