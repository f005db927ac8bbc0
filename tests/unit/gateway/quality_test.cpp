// SPDX-License-Identifier: Apache-2.0
// What the journal and unit 255 say of a line and its devices, and when.
#include <gmock/gmock.h>

#include "support/machine_rig.hpp"

namespace mbgate::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

Settings two_axes() {
  Settings settings = one_bus();
  settings.buses[0].timing.retries = 0;
  settings.devices = {{"axis", BusId{0}, 1, settings.buses[0].timing},
                      {"lift", BusId{0}, 2, settings.buses[0].timing}};
  return settings;
}

class JournalOfALine : public testing::Test {
 protected:
  JournalOfALine() { rig_.connect(1); }
  /// A request is on the wire, and was for 30 ms.
  void ask(unsigned unit = 1) {
    rig_.receive(1, read_request(1, unit));
    rig_.advance(30ms);
  }
  /// Until nothing is owed any more.
  void rest() { rig_.advance(300ms); }
  void ask_in_vain(int times, std::string_view heard, unsigned unit = 1) {
    for (int at = 0; at < times; ++at) {
      ask(unit);
      rig_.line(heard);
      rest();
    }
  }
  /// `count` input registers of unit 255.
  std::string registers(unsigned first, unsigned count) {
    rig_.take_sent(1);
    char request[64];
    std::snprintf(request, sizeof request, "0002 0000 0006 FF 04 %04X %04X", first, count);
    rig_.receive(1, request);
    const auto sent = rig_.take_sent(1);
    constexpr std::size_t kHeader = 27;  // of nine bytes as text
    return sent.size() == 1 && sent[0].size() > kHeader ? sent[0].substr(kHeader) : "";
  }

  MachineRig rig_{two_axes()};
};

constexpr auto kDamaged = "01 03 02 12 35 B5 33";
constexpr auto kDamagedOfTwo = "02 03 02 12 35 F1 33";
constexpr unsigned kLineQuality = 1054;
constexpr unsigned kAxisState = 10002;
constexpr unsigned kAxisQuality = 10022;

TEST_F(JournalOfALine, TellsBadCrcsOfADevice) {
  ask_in_vain(4, kDamaged);
  EXPECT_THAT(rig_.events, IsEmpty());
  EXPECT_EQ(registers(kAxisState, 1), "00 04");
  ask_in_vain(1, kDamaged);
  EXPECT_THAT(rig_.events,
              ElementsAre("device axis: bad CRC in 100 % of its answers (5 of 5): termination, "
                          "bias, cable, or two devices at one address"));
  EXPECT_EQ(registers(kAxisQuality, 3), "00 02 00 64 00 00");
  EXPECT_EQ(registers(kLineQuality, 2), "00 01 00 00");
}

TEST_F(JournalOfALine, TellsBadCrcsOfSeveralDevicesOfTheLine) {
  ask_in_vain(5, kDamaged);
  rig_.events.clear();
  ask_in_vain(5, kDamagedOfTwo, 2);
  EXPECT_THAT(rig_.events,
              ElementsAre(testing::StartsWith("device lift: bad CRC in 100 % of its answers"),
                          "bus line-a: bad CRC in 100 % of its answers (10 of 10): termination, "
                          "bias, cable; several devices have it; another client that "
                          "sends at the same time"));
  EXPECT_EQ(registers(kLineQuality, 2), "00 02 00 64");
}

TEST_F(JournalOfALine, TellsBytesThatNeverMakeAFrameUntilOneComes) {
  ask_in_vain(5, "E6 18 86 9E 06");
  EXPECT_THAT(rig_.events,
              ElementsAre("device axis: something answers, but no valid frame (bytes came after "
                          "each of 5 requests): baud rate, parity, A and B exchanged, two devices "
                          "at one address?"));
  EXPECT_EQ(registers(kAxisQuality, 3), "00 03 00 00 00 00");
  rig_.events.clear();
  rig_.advance(11s);  // what was asked in vain is not answered any more
  ask();
  rig_.respond("01 03 02 12 34");
  EXPECT_THAT(rig_.events, ElementsAre("device axis: its answers are good now"));
  EXPECT_EQ(registers(kAxisQuality, 3), "00 01 00 00 00 00");
}

// It answers 150 ms after the request was begun; the timeout ends at 104.6 ms.
TEST_F(JournalOfALine, TellsTheTimeoutThatASlowDriveNeeds) {
  for (int at = 0; at < 4; ++at) {
    ask();
    rig_.advance(120ms);
    rig_.respond("01 03 02 12 34");
    rest();
  }
  EXPECT_THAT(rig_.events,
              ElementsAre("device axis: its answers come 46 ms after its response timeout (after 4 "
                          "of its last 4 requests); set response_timeout to at least 160 ms"));
  EXPECT_EQ(registers(kAxisQuality, 3), "00 04 00 00 00 A0");
}

TEST_F(JournalOfALine, CallsOnlyADeviceLostThatHasAnswered) {
  Settings settings = two_axes();
  settings.devices[0].timing.offline_after = 2;
  settings.devices[0].timing.probe_interval = 0ms;
  rig_.reload(settings);
  rig_.events.clear();
  ask_in_vain(2, "");
  for (int times = 0; times < 2; ++times) {
    ask();  // the first answer may be late; the second shows that it is not
    rig_.respond("01 03 02 12 34");
    rest();
  }
  ask_in_vain(2, "");
  EXPECT_THAT(rig_.events,
              ElementsAre("device axis: no valid answer came so far, after 2 transmissions",
                          "device axis: answers", "device axis: does not answer any more"));
}

TEST_F(JournalOfALine, TellsAnotherClientByItsRequest) {
  rig_.advance(10s);
  rig_.line("01 03 00 10 00 01 85 CF");
  EXPECT_THAT(rig_.events, ElementsAre("device axis: a request to it was heard that the gateway "
                                       "did not send; another client is on this line"));
}

TEST_F(JournalOfALine, TellsASecondAnswerToOneRequest) {
  rig_.advance(10s);
  ask();
  rig_.respond("01 03 02 12 34");
  rig_.advance(5ms);
  rig_.respond("01 03 02 12 34");
  EXPECT_THAT(
      rig_.events,
      ElementsAre("device axis: two answers came to one request: two devices at one address?"));
}

TEST(Gateway, SaysWhetherALineHearsItself) {
  Settings settings = one_bus();
  settings.buses[0].line.echo.reset();
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, "0001 0000 0006 01 06 0000 0001");
  rig.advance(10ms);
  rig.line("01 06 00 00 00 01 48 0A");  // nobody was heard: it acknowledges nothing
  rig.advance(400ms);
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 01 00 00 00 03 01 86 0B"));
  rig.receive(1, "0002 0000 0006 01 03 0000 0001");
  rig.advance(10ms);
  rig.line("01 03 00 00 00 01 84 0A");
  rig.respond("01 03 02 12 34");
  EXPECT_THAT(
      rig.events,
      ElementsAre(
          "bus line-a: a write came back unchanged, and no read has shown yet whether that is its "
          "answer or an echo: until then it acknowledges nothing (set echo = true or echo = false)",
          "bus line-a: the adapter receives what it sends; the echo is checked from now on (echo = "
          "true: from the start)"));
}

TEST(JournalOfABabblingLine, SaysThatItIsNeverSilent) {
  MachineRig rig;
  for (int at = 0; at < 1200; ++at) {
    rig.line("55");
    rig.advance(1ms);
  }
  EXPECT_THAT(rig.events, ElementsAre(testing::StartsWith("bus line-a is never silent")));
}

}  // namespace
}  // namespace mbgate::test
