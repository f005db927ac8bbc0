// SPDX-License-Identifier: Apache-2.0
#include "sim/wire/wire.hpp"

#include <gmock/gmock.h>

#include "unit/sim/wire/wire_rig.hpp"

namespace mbgate::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::Pair;

sim::DeviceSettings moons(std::uint8_t address) { return {.address = address}; }

TEST(Wire, AnswersAfterSilenceAndProcessing) {
  WireRig rig(slow_line(), {moons(1)});
  rig.transmit(kReadStatus, 100ms);
  // 8 characters, t3.5, 1 ms of processing, then a character each millisecond.
  EXPECT_THAT(rig.run(),
              ElementsAre(Pair(113500us, "01"), Pair(114500us, "03"), Pair(115500us, "02"),
                          Pair(116500us, "00"), Pair(117500us, "09"), Pair(118500us, "78"),
                          Pair(119500us, "42")));
  EXPECT_EQ(rig.counters(), (sim::WireCounters{.frames = 1, .answers = 1}));
}

TEST(Wire, DeliversInChunksWithTheLastByteAtItsInstant) {
  auto settings = slow_line();
  settings.chunk = 4ms;
  WireRig rig(settings, {moons(1)});
  rig.transmit(kReadStatus, 100ms);
  EXPECT_THAT(rig.run(), ElementsAre(Pair(113500us, "01"), Pair(117500us, "03 02 00 09"),
                                     Pair(119500us, "78 42")));
}

TEST(Wire, DeliversTheSameHoweverLateItIsAsked) {
  WireRig rig(slow_line(), {moons(1)});
  rig.transmit(kReadStatus, 100ms);
  EXPECT_EQ(hex(rig.wire().advance(Instant(116500us))), "01 03 02 00");
  EXPECT_EQ(hex(rig.wire().advance(Instant(10s))), "09 78 42");
  EXPECT_EQ(rig.wire().next_event(), std::nullopt);
}

TEST(Wire, AddsResponseWaitAndProcessing) {
  WireRig rig(slow_line(), {{.address = 1, .response_wait = 20ms, .processing = 5ms}});
  rig.transmit(kReadStatus, 0ms);
  EXPECT_EQ(rig.run().front().first, 8ms + 3500us + 25ms + 1ms);
}

TEST(Wire, LetsAnAicWaitAsItsRegisterSays) {
  WireRig rig(slow_line(), {{.address = 17, .model = ModelKind::aic, .response_wait = 20ms}});
  rig.transmit("11 04 00 68 00 01 B2 86", 0ms);
  EXPECT_EQ(rig.wire().advance(Instant(33499us)).size(), 0U);
  EXPECT_EQ(rig.received(), "11 04 02 41 69 88 8D");
}

TEST(Wire, CountsAGapThatIsTooShort) {
  WireRig rig(slow_line(), {moons(1)});
  rig.transmit(kReadStatus, 0ms);
  EXPECT_EQ(rig.run().back().first, 19500us);
  rig.transmit(kReadStatus, 22999us);
  EXPECT_EQ(rig.counters().silence_violations, 1U);
  EXPECT_EQ(rig.run().back().first, 42499us);
  rig.transmit(kReadStatus, 45999us);
  EXPECT_EQ(rig.counters().silence_violations, 1U);
}

TEST(Wire, ChecksTheConfiguredGap) {
  auto settings = slow_line();
  settings.gap = 1ms;
  WireRig rig(settings, {moons(1)});
  rig.transmit(kReadStatus, 0ms);
  EXPECT_EQ(rig.run().back().first, 17ms);
  rig.transmit(kReadStatus, 18ms);
  EXPECT_EQ(rig.counters().silence_violations, 0U);
  EXPECT_EQ(rig.run().back().first, 35ms);
  rig.transmit(kReadStatus, 35999us);
  EXPECT_EQ(rig.counters().silence_violations, 1U);
}

TEST(Wire, TakesFramesWithoutSilenceBetweenThemForOne) {
  WireRig rig(slow_line(), {moons(1)});
  rig.transmit(kReadStatus, 0ms);
  rig.transmit(kReadStatus, 11ms);
  EXPECT_EQ(rig.received(), "");
  EXPECT_EQ(rig.counters(),
            (sim::WireCounters{.frames = 1, .silence_violations = 1, .bad_crc = 1}));
  EXPECT_EQ(rig.wire().frames().front().bytes.size(), 16U);
}

TEST(Wire, KeepsFramesApartThatSilenceParts) {
  WireRig rig(slow_line(), {moons(1), moons(2)});
  rig.wire().device(1)->set_faults({.silent = true});
  rig.transmit(kReadStatus, 0ms);
  rig.transmit(kReadStatus2, 11500us);
  EXPECT_EQ(rig.received(), kStatus2);
  EXPECT_EQ(rig.counters(), (sim::WireCounters{.frames = 2, .answers = 1}));
}

TEST(Wire, PutsATransmissionBehindTheOneUnderWay) {
  WireRig rig(slow_line(), {moons(1)});
  rig.transmit("01 03 00 01", 0ms);
  rig.transmit("00 01 D5 CA", 1ms);
  EXPECT_EQ(rig.received(), kStatus);
  EXPECT_EQ(rig.wire().frames().front().end, Instant(8ms));
}

TEST(Wire, DamagesWhatOverlaps) {
  WireRig rig(slow_line(), {moons(1), moons(2)});
  rig.wire().device(1)->set_faults({.answer_after = 40ms});
  rig.transmit(kReadStatus, 0ms);    // answered from 48 ms to 55 ms
  rig.transmit(kReadStatus2, 42ms);  // until 50 ms
  EXPECT_EQ(rig.received(), "FE FC 02 00 09 78 42");
  EXPECT_EQ(rig.counters(),
            (sim::WireCounters{.frames = 2, .answers = 1, .collisions = 1, .bad_crc = 1}));
  EXPECT_EQ(hex(rig.wire().frames().back().bytes), "02 03 00 01 00 01 2A 06");
}

TEST(Wire, DamagesTwoAnswersAtOnce) {
  WireRig rig(slow_line(), {moons(1), moons(1)});
  rig.transmit(kReadStatus, 0ms);
  EXPECT_EQ(rig.wire().advance(Instant(1s)).size(), 14U);
  EXPECT_EQ(rig.counters().collisions, 1U);
}

TEST(Wire, CountsNoViolationForACollision) {
  WireRig rig(slow_line(), {moons(1)});
  rig.transmit(kReadStatus, 0ms);
  rig.wire().advance(Instant(14ms));
  rig.transmit(kReadStatus, 15ms);
  rig.run();
  EXPECT_EQ(rig.counters().collisions, 1U);
  EXPECT_EQ(rig.counters().silence_violations, 0U);
}

TEST(Wire, CarriesABroadcastToAllWhoHearItsForm) {
  WireRig rig(slow_line(), {moons(1),
                            {.address = 2, .model = ModelKind::stepper},
                            {.address = 17, .model = ModelKind::aic}});
  rig.transmit("00 06 00 7C 00 E1 89 8B", 0ms);
  rig.transmit("81 85 00 17 FF 00 22 20", 100ms);
  EXPECT_EQ(rig.received(), "");
  EXPECT_EQ(rig.counters(), (sim::WireCounters{.frames = 2}));
  EXPECT_THAT(rig.wire().frames()[0].heard_by, ElementsAre(1, 2));
  EXPECT_THAT(rig.wire().frames()[1].heard_by, ElementsAre(17));
}

TEST(Wire, EchoesTheGatewaysOwnTransmission) {
  auto settings = slow_line();
  settings.echo = true;
  WireRig rig(settings, {moons(1)});
  rig.transmit(kReadStatus, 0ms);
  EXPECT_EQ(hex(rig.wire().advance(Instant(8ms))), kReadStatus);
  EXPECT_EQ(rig.received(), kStatus);
}

TEST(Wire, DelaysTheEchoAndWhatComesBehindIt) {
  auto settings = slow_line();
  settings.echo = true;
  settings.echo_delay = 20ms;
  WireRig rig(settings, {moons(1)});
  rig.transmit(kReadStatus, 0ms);
  EXPECT_EQ(hex(rig.wire().advance(Instant(20999us))), "");
  EXPECT_EQ(hex(rig.wire().advance(Instant(27999us))), "01 03 00 01 00 01 D5");
  // By then the answer has been on the wire for long.
  EXPECT_EQ(hex(rig.wire().advance(Instant(28ms))), std::string("CA ") + kStatus);
}

TEST(Wire, DrivesTakeNothingInAnotherModeThanTheirs) {
  const sim::PortMode right{modbus::Baud{10000}, {8, modbus::Parity::none, 1}};
  std::vector<sim::PortMode> wrong(5, right);
  wrong[0].baud = modbus::Baud{9600};
  wrong[1].format.parity = modbus::Parity::even;
  wrong[2].format.parity = modbus::Parity::odd;
  wrong[3].format.stop_bits = 2;
  wrong[4].format.data_bits = 7;
  for (const sim::PortMode& mode : wrong) {
    WireRig rig(slow_line(), {moons(1)});
    rig.wire().set_port(mode);
    rig.transmit(kReadStatus, 0ms);
    EXPECT_EQ(rig.received(), "");
    EXPECT_EQ(rig.counters(), (sim::WireCounters{.frames = 1, .bad_crc = 1}));
    EXPECT_THAT(rig.wire().frames()[0].heard_by, ElementsAre());
    rig.wire().set_port(right);
    rig.transmit(kReadStatus, 100ms);
    EXPECT_EQ(rig.received(), kStatus);
  }
}

TEST(Wire, ARateNearTheirsIsTheirs) {
  WireRig rig(slow_line(), {moons(1)});
  rig.wire().set_port({modbus::Baud{10200}, {8, modbus::Parity::none, 1}});
  rig.transmit(kReadStatus, 0ms);
  EXPECT_EQ(rig.received(), kStatus);
}

TEST(Wire, AnotherRateTakesItsOwnTime) {
  WireRig rig(slow_line(), {moons(1)});
  rig.wire().set_port({modbus::Baud{1000}, {8, modbus::Parity::none, 1}});
  rig.transmit(kReadStatus, 0ms);
  rig.run();
  EXPECT_EQ(rig.wire().frames()[0].end, Instant(80ms));
}

TEST(Wire, HoldsBytesBackInTheAdapter) {
  auto settings = slow_line();
  settings.adapter_latency = 4ms;
  WireRig rig(settings, {moons(1)});
  rig.transmit(kReadStatus, 100ms);
  EXPECT_THAT(rig.run(), ElementsAre(Pair(117500us, "01 03 02 00 09"), Pair(122500us, "78 42")));
}

TEST(Wire, TakesNoTimeWhenUnpaced) {
  auto settings = slow_line();
  settings.paced = false;
  WireRig rig(settings, {moons(1)});
  for (int i = 0; i < 3; ++i) {
    rig.transmit(kReadStatus, 5ms);
    EXPECT_EQ(hex(rig.wire().advance(Instant(5ms))), kStatus);
  }
  EXPECT_EQ(rig.counters(), (sim::WireCounters{.frames = 3, .answers = 3}));
}

TEST(Wire, KeepsTheNewestFrames) {
  auto settings = slow_line();
  settings.frames_kept = 1;
  WireRig rig(settings, {moons(1)});
  rig.transmit(kReadStatus, 0ms);
  rig.transmit("01 03 00 01 00 01 D5 CB", 100ms);
  rig.run();
  ASSERT_EQ(rig.wire().frames().size(), 1U);
  const sim::FrameOnWire& frame = rig.wire().frames().front();
  EXPECT_EQ(frame.begin, Instant(100ms));
  EXPECT_EQ(frame.end, Instant(108ms));
  EXPECT_FALSE(frame.intact);
  EXPECT_THAT(frame.heard_by, IsEmpty());
  EXPECT_EQ(rig.counters().bad_crc, 1U);
}

TEST(Wire, LosesWhatIsOnItWhenTheAdapterVanishes) {
  WireRig rig(slow_line(), {moons(1)});
  rig.transmit("01 06 00 7C 00 E1 88 5A", 0ms);
  rig.wire().advance(Instant(15ms));
  rig.wire().disconnect();
  EXPECT_EQ(rig.wire().next_event(), std::nullopt);
  EXPECT_THAT(rig.wire().advance(Instant(1s)), IsEmpty());
  rig.transmit(kReadStatus, 1s);
  EXPECT_EQ(rig.received(), kStatus);
}

TEST(Wire, ChecksTheGapInRealTimeOnlyAfterAnAnswer) {
  auto settings = slow_line();
  settings.clocking = sim::Clocking::real_time;
  WireRig rig(settings, {moons(1)});
  rig.transmit(kReadStatus2, 0ms);
  rig.transmit(kReadStatus, 9ms);
  EXPECT_EQ(rig.counters().silence_violations, 0U);
  EXPECT_EQ(rig.run().back().first, 28500us);
  EXPECT_EQ(rig.counters().frames, 2U);
  rig.transmit(kReadStatus, 31ms);
  EXPECT_EQ(rig.counters().silence_violations, 1U);
}

}  // namespace
}  // namespace mbgate::test
