// SPDX-License-Identifier: Apache-2.0
// What a trace says of requests that go through a whole machine.
#include "gateway/trace/trace_book.hpp"

#include <gmock/gmock.h>

#include "unit/gateway/trace/trace_lines.hpp"

namespace mbgate::test {
namespace {

using gateway::TraceBook;
using gateway::TraceRecord;
using gateway::WireTrace;
using testing::ElementsAre;
using testing::IsEmpty;

class Trace : public testing::Test {
 protected:
  Trace() {
    rig_.connect(1, "192.0.2.7");
    rig_.connect(2, "192.0.2.8");
    rig_.harness.gateway().set_traced(true);
  }
  Lines take() { return taken_lines(rig_); }

  MachineRig rig_{one_axis()};
};

TEST_F(Trace, HasBothSidesOfARequest) {
  rig_.receive(1, read_request(7));
  rig_.advance(30ms);
  rig_.respond("01 03 02 12 34");
  const auto taken = rig_.harness.gateway().take_trace(rig_.now());
  ASSERT_EQ(taken.records.size(), 1U);
  const TraceRecord& record = taken.records[0];
  EXPECT_EQ(text(record),
            "00 07 00 00 00 06 01 03 00 00 00 01 = 00 07 00 00 00 05 01 03 02 12 34"
            " / line-a axis> 01 03 00 00 00 01 84 0A < 01 03 02 12 34 B5 33 answered");
  EXPECT_EQ(record.asked->client.to_text(), "192.0.2.7");
  EXPECT_EQ(record.asked->listener, "plant");
  EXPECT_EQ(record.asked->connection, ClientId{1});
  EXPECT_EQ(record.asked->answered_at, rig_.now());
  EXPECT_EQ(record.asked->answered_at - record.asked->asked_at, Duration{30ms});
  EXPECT_EQ(record.wire[0].sent_at, record.asked->asked_at);
  EXPECT_EQ(record.wire[0].ended_at, rig_.now());
  EXPECT_EQ(hex(*record.wire[0].response), "03 02 12 34");
  EXPECT_EQ(record.ended_as, bus::Ending::answered);
  EXPECT_FALSE(record.is_failed());
}

TEST(TraceOfImpatientClients, HasNoAnswerThatTheyDidNotGet) {
  Settings settings = one_axis();
  settings.listeners[0].give_up = 50ms;
  MachineRig rig(settings);
  rig.harness.gateway().set_traced(true);
  rig.connect(1);
  rig.receive(1, read_request(7));
  rig.advance(60ms);
  rig.respond("01 03 02 12 34");
  const auto taken = rig.harness.gateway().take_trace(rig.now());
  ASSERT_EQ(taken.records.size(), 1U);
  EXPECT_FALSE(taken.records[0].asked->answer);
  EXPECT_EQ(taken.records[0].ended_as, bus::Ending::answered);
}

TEST_F(Trace, HasEveryTryAndWhatWasHeardOfIt) {
  rig_.receive(1, read_request(7));
  rig_.advance(20ms);
  rig_.line("01 03 02 12 34 FF FF");  // bad CRC
  rig_.advance(120ms);
  rig_.respond("01 03 02 12 34");
  rig_.advance(400ms);
  EXPECT_THAT(take(),
              ElementsAre("00 07 00 00 00 06 01 03 00 00 00 01 = 00 07 00 00 00 05 01 03 02 12 34"
                          " / line-a axis> 01 03 00 00 00 01 84 0A < 01 03 02 12 34 FF FF damaged"
                          " / line-a axis> 01 03 00 00 00 01 84 0A < 01 03 02 12 34 B5 33 "
                          "answered"));
}

TEST_F(Trace, SaysWhenTheLineWasSilentAndWhenAFrameHadLeft) {
  const Instant opened{};
  rig_.advance(40ms);
  rig_.receive(1, read_request(7));
  const Instant sent = rig_.now();
  rig_.advance(30ms);
  rig_.respond("01 03 02 12 34");
  const Instant heard = rig_.now();
  rig_.receive(1, read_request(8));
  rig_.advance(30ms);
  rig_.respond("01 03 02 12 34");
  const auto taken = rig_.harness.gateway().take_trace(rig_.now());
  ASSERT_EQ(taken.records.size(), 2U);
  const modbus::RtuTiming timing(modbus::Baud{19200}, {});
  const WireTrace& first = taken.records[0].wire[0];
  EXPECT_EQ(first.silent_since, opened);
  EXPECT_EQ(first.left_at, sent + timing.duration_of(8));
  EXPECT_EQ(first.held_until, std::nullopt);
  const WireTrace& second = taken.records[1].wire[0];
  EXPECT_EQ(second.silent_since, heard);
  EXPECT_GE(second.sent_at - heard, timing.t3_5());
}

TEST_F(Trace, SaysHowLongADeviceIsHeldBackThatDoesNotAnswer) {
  rig_.receive(1, write_request(7));
  rig_.advance(1s);
  const auto taken = rig_.harness.gateway().take_trace(rig_.now());
  ASSERT_EQ(taken.records.size(), 1U);
  const WireTrace& wire = taken.records[0].wire[0];
  ASSERT_EQ(wire.outcome, WireTrace::Outcome::no_response);
  // One more response timeout, and what an adapter may keep.
  EXPECT_EQ(*wire.held_until - wire.ended_at, Duration{100ms + 20ms});
}

TEST_F(Trace, ASilentDeviceFails) {
  rig_.receive(1, read_request(7));
  rig_.advance(1s);
  const auto taken = rig_.harness.gateway().take_trace(rig_.now());
  ASSERT_EQ(taken.records.size(), 1U);
  EXPECT_EQ(text(taken.records[0]),
            "00 07 00 00 00 06 01 03 00 00 00 01 = 00 07 00 00 00 03 01 83 0B"
            " / line-a axis> 01 03 00 00 00 01 84 0A < no response"
            " / line-a axis> 01 03 00 00 00 01 84 0A < no response");
  EXPECT_EQ(taken.records[0].wire[1].tries, 2U);
  EXPECT_EQ(taken.records[0].ended_as, bus::Ending::no_answer);
  EXPECT_TRUE(taken.records[0].is_failed());
}

TEST_F(Trace, OneFrameCanBeOfSeveralRequests) {
  rig_.receive(1, read_request(6, 2));  // the line is busy
  rig_.receive(1, read_request(7));
  rig_.receive(2, read_request(8));
  rig_.advance(10ms);
  rig_.respond("02 03 02 00 00");
  rig_.advance(10ms);
  take();
  rig_.respond("01 03 02 12 34");
  const auto taken = rig_.harness.gateway().take_trace(rig_.now());
  ASSERT_EQ(taken.records.size(), 2U);
  EXPECT_EQ(taken.records[0].wire[0].shared_by, 2U);
  EXPECT_EQ(hex(taken.records[0].wire[0].frame), hex(taken.records[1].wire[0].frame));
}

TEST_F(Trace, TellsWhatTheGatewayAnswersItself) {
  rig_.advance(10ms);
  rig_.receive(1, read_request(7, 248));  // no route
  const auto taken = rig_.harness.gateway().take_trace(rig_.now());
  ASSERT_EQ(taken.records.size(), 1U);
  EXPECT_EQ(text(taken.records[0]),
            "00 07 00 00 00 06 F8 03 00 00 00 01 = 00 07 00 00 00 03 F8 83 0A");
  EXPECT_TRUE(taken.records[0].asked->refused);
  EXPECT_EQ(taken.records[0].asked->answered_at, rig_.now());
  EXPECT_TRUE(taken.records[0].is_failed());
}

TEST_F(Trace, BytesThatNobodyAskedForAreToldAfterAPause) {
  rig_.line("09 03 02");
  rig_.advance(10ms);
  rig_.line("00 01 D8");
  rig_.advance(10ms);
  EXPECT_THAT(take(), IsEmpty());
  rig_.advance(50ms);
  EXPECT_THAT(take(), ElementsAre("= / line-a >  < 09 03 02 00 01 D8 unasked"));
  EXPECT_THAT(take(), IsEmpty());
}

TEST_F(Trace, WhatIsCutWithItsLineIsTold) {
  rig_.receive(1, write_request(7));
  rig_.advance(10ms);
  rig_.lose_line();
  EXPECT_THAT(take(), ElementsAre("00 07 00 00 00 06 01 06 00 00 00 01 = "
                                  "00 07 00 00 00 03 01 86 0B"
                                  " / line-a axis> 01 06 00 00 00 01 48 0A < cut"));
}

TEST_F(Trace, ARequestWhoseClientHasGoneHasNoAnswer) {
  rig_.receive(1, write_request(7));
  rig_.advance(10ms);
  rig_.disconnect(1);
  rig_.respond("01 06 00 00 00 01");
  EXPECT_THAT(take(), ElementsAre("00 07 00 00 00 06 01 06 00 00 00 01 ="
                                  " / line-a axis> 01 06 00 00 00 01 48 0A < "
                                  "01 06 00 00 00 01 48 0A answered"));
}

TEST_F(Trace, OfARequestThatCameBeforeItHasTheFramesThatFollow) {
  rig_.harness.gateway().set_traced(false);
  rig_.receive(1, read_request(6, 2));
  rig_.receive(1, read_request(7));
  rig_.advance(10ms);
  rig_.harness.gateway().set_traced(true);
  rig_.respond("02 03 02 00 00");
  rig_.advance(10ms);
  rig_.respond("01 03 02 12 34");
  EXPECT_THAT(take(), ElementsAre("= / line-a axis> 01 03 00 00 00 01 84 0A < "
                                  "01 03 02 12 34 B5 33 answered"));
}

TEST_F(Trace, TakesNothingWhileItIsOff) {
  rig_.harness.gateway().set_traced(false);
  rig_.receive(1, read_request(7));
  rig_.advance(30ms);
  rig_.respond("01 03 02 12 34");
  EXPECT_THAT(take(), IsEmpty());
}

TEST_F(Trace, CountsWhatIsNotTakenInTime) {
  for (std::size_t at = 0; at < TraceBook::kMostRecords + 3; ++at) {
    rig_.receive(1, read_request(7, 248));
  }
  const auto taken = rig_.harness.gateway().take_trace(rig_.now());
  EXPECT_EQ(taken.records.size(), TraceBook::kMostRecords);
  EXPECT_EQ(taken.lost, 3U);
}

TEST_F(Trace, KeepsOnlySoMuchOfWhatIsHeard) {
  rig_.receive(1, read_request(7));
  for (int at = 0; at < 100; ++at) {
    rig_.line("55 55 55 55 55 55 55 55 55 55 55 55 55 55 55 55");
  }
  rig_.advance(1s);
  const auto taken = rig_.harness.gateway().take_trace(rig_.now());
  ASSERT_FALSE(taken.records.empty());
  EXPECT_EQ(taken.records[0].wire[0].not_kept, 1600U - gateway::LineTrace::kMostHeard);
}

TEST_F(Trace, SaysWhereARequestWasToGo) {
  rig_.lose_line();
  rig_.receive(1, write_request(7));
  const auto taken = rig_.harness.gateway().take_trace(rig_.now());
  ASSERT_EQ(taken.records.size(), 1U);
  EXPECT_TRUE(taken.records[0].wire.empty());
  ASSERT_EQ(taken.records[0].asked->targets.size(), 1U);
  EXPECT_EQ(taken.records[0].asked->targets[0].bus, "line-a");
  EXPECT_EQ(taken.records[0].asked->targets[0].device, "axis");
  EXPECT_EQ(taken.records[0].ended_as, bus::Ending::closed);
}

TEST_F(Trace, ALineThatIsNeverSilentIsToldOf) {
  for (int at = 0; at < 120; ++at) {
    rig_.line("55");
    rig_.advance(10ms);
  }
  EXPECT_EQ(take().size(), 1U);
}

TEST_F(Trace, DecidesNothingWhenItIsTurnedOn) {
  rig_.receive(1, read_request(7));
  rig_.receive(2, read_request(8, 2));
  rig_.harness.gateway().set_traced(false);
  rig_.harness.gateway().set_traced(true);
  EXPECT_FALSE(rig_.harness.gateway().poll_action());
}

TEST(TraceOfABroadcast, ThatIsNotAnsweredIsNoFailure) {
  Settings settings = one_bus();
  settings.routes.clear();
  settings.listeners[0].bus = BusId{0};
  settings.listeners[0].broadcast = true;
  settings.listeners[0].broadcast_reply = routing::BroadcastReply::none;
  MachineRig rig{settings};
  rig.connect(1);
  rig.harness.gateway().set_traced(true);
  rig.receive(1, "0007 0000 0006 00 06 0000 0001");
  rig.advance(200ms);
  rig.receive(1, "0008 0000 0006 01 06 0000 0001");
  rig.advance(10ms);
  rig.disconnect(1);
  rig.respond("01 06 00 00 00 01");
  const auto taken = rig.harness.gateway().take_trace(rig.now());
  ASSERT_EQ(taken.records.size(), 2U);
  EXPECT_EQ(text(taken.records[0]),
            "00 07 00 00 00 06 00 06 00 00 00 01 = / line-a > 00 06 00 00 00 01 49 DB < sent");
  EXPECT_FALSE(taken.records[0].is_failed());
  EXPECT_EQ(text(taken.records[1]),
            "00 08 00 00 00 06 01 06 00 00 00 01 = / line-a > 01 06 00 00 00 01 48 0A < "
            "01 06 00 00 00 01 48 0A answered");
  EXPECT_TRUE(taken.records[1].is_failed()) << "its client has gone";
}

}  // namespace
}  // namespace mbgate::test
