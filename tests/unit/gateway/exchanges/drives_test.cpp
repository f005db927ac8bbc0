// SPDX-License-Identifier: Apache-2.0
// Requests to drives that the gateway knows: several transactions that are one answer.
#include <gmock/gmock.h>

#include "support/machine_rig.hpp"

namespace mbgate::test::drives_test {
namespace {

using drive::WordOrder;
using modbus::Table;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr std::size_t kMbap = 3 * 7;  // characters of hexadecimal text

/// Unit 1 is a drive with low word first behind a route that wants high word first; a 32-bit value
/// at 30, at most 5 registers a request.
Settings one_drive() {
  Settings settings = one_bus();
  drive::Device device;
  device.name = "axis-x";
  device.timing.response_timeout = 100ms;
  device.timing.retries = 0;
  device.word_order = WordOrder::little;
  device.profile.values.add({Table::holding_registers, 30});
  device.profile.limits.read[2] = 5;
  device.profile.limits.write_registers = 5;
  device.profile.communication = {{Table::holding_registers, 50, 1}};
  settings.devices = {device};
  settings.routes[0].last_unit = 1;
  settings.routes[0].device = 0;
  settings.routes[0].word_order = WordOrder::big;
  auto& other = settings.routes.emplace_back();
  other.first_unit = other.first_address = other.last_unit = 2;
  other.buses = {BusId{0}};
  return settings;
}

std::string without_crc(const std::string& frame) { return frame.substr(0, frame.size() - 6); }

std::vector<std::string> take_texts(MachineRig& rig) {
  std::vector<std::string> requests;
  for (const auto& frame : rig.take_transmitted()) {
    requests.push_back(without_crc(frame));
  }
  return requests;
}

std::vector<std::string> take_answers(MachineRig& rig, std::uint64_t client) {
  std::vector<std::string> answers;
  for (const auto& adu : rig.take_sent(client)) {
    answers.push_back(adu.substr(kMbap - 3));
  }
  return answers;
}

TEST(Drives, SpeakTheirOwnWordOrder) {
  MachineRig rig(one_drive());
  rig.connect(1);
  rig.receive(1, "0001 0000 000B 01 10 001E 0002 04 0003 0D40");
  EXPECT_THAT(take_texts(rig), ElementsAre("01 10 00 1E 00 02 04 0D 40 00 03"));
  rig.respond("01 10 00 1E 00 02");
  EXPECT_THAT(take_answers(rig, 1), ElementsAre("01 10 00 1E 00 02"));
  rig.advance(10ms);
  rig.receive(1, "0002 0000 0006 01 03 001E 0002");
  EXPECT_THAT(take_texts(rig), ElementsAre("01 03 00 1E 00 02"));
  rig.respond("01 03 04 0D40 0003");
  EXPECT_THAT(take_answers(rig, 1), ElementsAre("01 03 04 00 03 0D 40"));
}

TEST(Drives, NothingComesBetweenTheTransactionsOfOneRequest) {
  MachineRig rig(one_drive());
  rig.connect(1);
  rig.connect(2, "192.0.2.2");
  rig.receive(1, "0001 0000 0006 01 03 001B 000A");
  rig.receive(2, "0001 0000 0006 02 03 0000 0001");
  EXPECT_THAT(take_texts(rig), ElementsAre("01 03 00 1B 00 05"));
  rig.respond("01 03 0A 0001 0002 0003 0D40 0003");
  rig.advance(30ms);
  EXPECT_THAT(take_texts(rig), ElementsAre("01 03 00 20 00 05"));
  EXPECT_THAT(take_answers(rig, 1), IsEmpty());
  rig.respond("01 03 0A 0006 0007 0008 0009 000A");
  EXPECT_THAT(take_answers(rig, 1), ElementsAre("01 03 14 00 01 00 02 00 03 00 03 0D 40 00 06 "
                                                "00 07 00 08 00 09 00 0A"));
  rig.advance(30ms);
  EXPECT_THAT(take_texts(rig), ElementsAre("02 03 00 00 00 01"));
}

TEST(Drives, AnExceptionOfAPartEndsTheRequest) {
  MachineRig rig(one_drive());
  rig.connect(1);
  rig.receive(1, "0001 0000 0006 01 03 001B 000A");
  rig.respond("01 83 11");
  EXPECT_THAT(take_answers(rig, 1), ElementsAre("01 83 11"));
  rig.advance(1s);
  EXPECT_THAT(take_texts(rig), ElementsAre("01 03 00 1B 00 05"));
}

Settings splitting_drive() {
  Settings settings = one_drive();
  settings.devices[0].split_writes = true;
  return settings;
}

constexpr auto* kLongWrite = "0001 0000 0015 01 10 0000 0007 0E 0001 0002 0003 0004 0005 0006 0007";

TEST(Drives, AWriteThatEndsHalfWaySaysSoInTheJournal) {
  MachineRig rig(splitting_drive());
  rig.connect(1);
  rig.receive(1, kLongWrite);
  rig.respond("01 10 00 00 00 05");
  rig.advance(30ms);
  rig.respond("01 90 13");
  EXPECT_THAT(take_answers(rig, 1), ElementsAre("01 90 13"));
  EXPECT_THAT(rig.events,
              ElementsAre("device axis-x: a write of holding registers 0 to 6 ended early; written "
                          "up to 4"));
}

TEST(Drives, AWriteWhosePartIsNotAnsweredMayHaveBeenDone) {
  MachineRig rig(splitting_drive());
  rig.connect(1);
  rig.receive(1, kLongWrite);
  rig.respond("01 10 00 00 00 05");
  rig.advance(200ms);
  EXPECT_THAT(take_answers(rig, 1), ElementsAre("01 90 0B"));
  EXPECT_EQ(rig.events.size(), 1U);
}

TEST(Drives, AWriteWhoseFirstPartFailsHasWrittenNothing) {
  MachineRig rig(splitting_drive());
  rig.connect(1);
  rig.receive(1, kLongWrite);
  rig.respond("01 90 13");
  EXPECT_THAT(take_answers(rig, 1), ElementsAre("01 90 13"));
  EXPECT_THAT(rig.events, IsEmpty());
}

TEST(Drives, AWriteOfCommunicationRegistersIsRefusedOrJournaled) {
  MachineRig refusing(one_drive());
  refusing.connect(1);
  refusing.receive(1, "0001 0000 0006 01 06 0032 0085");
  EXPECT_THAT(take_answers(refusing, 1), ElementsAre("01 86 01"));
  EXPECT_THAT(take_texts(refusing), IsEmpty());
  Settings settings = one_drive();
  settings.devices[0].allow_reconfigure = true;
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, "0001 0000 0006 01 06 0032 0085");
  rig.respond("01 06 00 32 00 85");
  EXPECT_THAT(take_answers(rig, 1), ElementsAre("01 06 00 32 00 85"));
  EXPECT_THAT(rig.events, ElementsAre("device axis-x: client 192.0.2.1 has written its "
                                      "communication registers"));
}

TEST(Drives, AWriteOfCommunicationRegistersIsJournaledIfItMayHaveBeenDone) {
  Settings settings = one_drive();
  settings.devices[0].allow_reconfigure = true;
  settings.devices[0].profile.acceptances.set(5);
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, "0001 0000 0006 01 06 0032 0085");
  rig.respond("01 86 04");
  EXPECT_THAT(take_answers(rig, 1), ElementsAre("01 86 04"));
  EXPECT_THAT(rig.events, IsEmpty());
  rig.advance(10ms);
  rig.receive(1, "0003 0000 0006 01 06 0032 0085");
  rig.respond("01 86 05");  // by which this drive says that it does so
  EXPECT_THAT(take_answers(rig, 1), ElementsAre("01 86 05"));
  EXPECT_THAT(std::exchange(rig.events, {}), testing::SizeIs(1));
  rig.advance(10ms);
  rig.receive(1, "0002 0000 0006 01 06 0032 0085");
  rig.advance(200ms);
  EXPECT_THAT(take_answers(rig, 1), ElementsAre("01 86 0B"));
  EXPECT_THAT(rig.events, ElementsAre("device axis-x: client 192.0.2.1 has written its "
                                      "communication registers"));
}

TEST(Drives, AWriteOfCommunicationRegistersThroughTheBusIsJournaledToo) {
  Settings settings = one_drive();
  settings.routes[1].first_address = 1;
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, "0001 0000 0006 02 06 0032 0085");
  rig.respond("01 06 00 32 00 85");
  EXPECT_THAT(take_answers(rig, 1), ElementsAre("02 06 00 32 00 85"));
  EXPECT_EQ(rig.events.size(), 1U);
}

TEST(Drives, ABusAndAddressRouteExchangesNothing) {
  Settings settings = one_drive();
  settings.routes[1].first_address = 1;
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, "0001 0000 0006 02 03 001E 0001");
  EXPECT_THAT(take_texts(rig), ElementsAre("01 03 00 1E 00 01"));
  rig.respond("01 03 02 0D40");
  EXPECT_THAT(take_answers(rig, 1), ElementsAre("02 03 02 0D 40"));
}

Settings verified_drive() {
  Settings settings = one_drive();
  settings.devices[0].verify_word_order = true;
  settings.devices[0].profile.word_order_register =
      drive::WordOrderRegister{50, {5, 261}, {133, 389}};
  return settings;
}

constexpr auto* kValueWrite = "0001 0000 000B 01 10 001E 0002 04 0003 0D40";

TEST(Drives, TheirOwnWordOrderIsReadBeforeTheFirstValueIsWritten) {
  MachineRig rig(verified_drive());
  rig.connect(1);
  rig.receive(1, kValueWrite);
  EXPECT_THAT(take_texts(rig), ElementsAre("01 03 00 32 00 01"));
  rig.respond("01 03 02 0185");
  rig.advance(30ms);
  EXPECT_THAT(take_texts(rig), ElementsAre("01 10 00 1E 00 02 04 0D 40 00 03"));
  rig.respond("01 10 00 1E 00 02");
  EXPECT_THAT(take_answers(rig, 1), ElementsAre("01 10 00 1E 00 02"));
  rig.advance(30ms);
  rig.receive(1, kValueWrite);
  EXPECT_THAT(take_texts(rig), ElementsAre("01 10 00 1E 00 02 04 0D 40 00 03"));
  // An answer that did not come: the drive may have been set otherwise meanwhile.
  rig.advance(300ms);
  EXPECT_THAT(take_answers(rig, 1), ElementsAre("01 90 0B"));
  rig.receive(1, kValueWrite);
  EXPECT_THAT(take_texts(rig), ElementsAre("01 03 00 32 00 01"));
}

TEST(Drives, TheirWordOrderIsReadAgainAfterItWasWritten) {
  Settings settings = verified_drive();
  settings.devices[0].allow_reconfigure = true;
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, kValueWrite);
  rig.respond("01 03 02 0085");
  rig.advance(30ms);
  rig.respond("01 10 00 1E 00 02");
  rig.advance(30ms);
  rig.receive(1, "0002 0000 0006 01 06 0032 0005");
  rig.respond("01 06 00 32 00 05");
  rig.advance(30ms);
  take_texts(rig);
  rig.receive(1, kValueWrite);
  EXPECT_THAT(take_texts(rig), ElementsAre("01 03 00 32 00 01"));
  rig.respond("01 03 02 0005");
  EXPECT_EQ(take_answers(rig, 1).back(), "01 90 04");
}

TEST(Drives, AWriteThatWaitsBehindAChangeOfTheWordOrderAsksAgain) {
  Settings settings = verified_drive();
  settings.devices[0].allow_reconfigure = true;
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, kValueWrite);
  rig.respond("01 03 02 0085");
  rig.advance(30ms);
  rig.respond("01 10 00 1E 00 02");
  rig.advance(30ms);
  take_texts(rig);
  rig.receive(1, std::string("0002 0000 0006 01 06 0032 0005") + kValueWrite);
  rig.respond("01 06 00 32 00 05");
  rig.advance(30ms);
  EXPECT_THAT(take_texts(rig), ElementsAre("01 06 00 32 00 05", "01 03 00 32 00 01"));
}

TEST(Drives, ValuesAreNotWrittenToADriveOfAnotherWordOrder) {
  MachineRig rig(verified_drive());
  rig.connect(1);
  rig.receive(1, kValueWrite);
  rig.receive(1, "0002 0000 0006 01 06 0000 0001");  // no value
  rig.respond("01 03 02 0005");
  EXPECT_THAT(take_answers(rig, 1), ElementsAre("01 90 04"));
  EXPECT_THAT(rig.events, ElementsAre("device axis-x: its own word order is not the one "
                                      "configured; values are not written to it"));
  rig.advance(30ms);
  EXPECT_THAT(take_texts(rig), ElementsAre("01 03 00 32 00 01", "01 06 00 00 00 01"));
  rig.respond("01 06 00 00 00 01");
  take_answers(rig, 1);
  rig.advance(30ms);
  rig.receive(1, kValueWrite);
  EXPECT_THAT(take_texts(rig), ElementsAre("01 03 00 32 00 01"));  // it may be right by now
  rig.respond("01 83 02");
  EXPECT_THAT(take_answers(rig, 1), ElementsAre("01 90 04"));
}

TEST(Drives, AWriteBehindAnUnansweredQuestionWasNeverTransmitted) {
  MachineRig rig(verified_drive());
  rig.connect(1);
  rig.receive(1, kValueWrite);
  rig.advance(200ms);
  EXPECT_THAT(take_answers(rig, 1), ElementsAre("01 90 06"));
  EXPECT_THAT(take_texts(rig), ElementsAre("01 03 00 32 00 01"));
}

}  // namespace
}  // namespace mbgate::test::drives_test
