// SPDX-License-Identifier: Apache-2.0
// The printed frames of the drive manuals driven through the machine: the TCP ADU in, exactly
// the RTU bytes out; the RTU response in, exactly the TCP ADU out.
#include <gmock/gmock.h>

#include "unit/gateway/exchanges/printed_examples.hpp"

namespace mbgate::test {
namespace {

using testing::Contains;

constexpr auto* kSpeaksRtu =
    "listener plant: client 192.0.2.2 sends RTU frames to the Modbus TCP port; it must be set to "
    "Modbus TCP";

TEST(PrintedPairs, GoThroughARouteAndBack) {
  const auto examples = printed_pairs();
  ASSERT_EQ(examples.size(), 37U);
  MachineRig rig(routed_and_transparent());
  rig.connect(1, "192.0.2.1", kRouted);
  for (const Example& example : examples) {
    expect_exchange(rig, 1, example);
  }
  EXPECT_EQ(next_adu(rig, 1, 1s), "");
  EXPECT_EQ(next_frame(rig, 1s), "");
}

TEST(PrintedPairs, GoThroughATransparentListenerAndBack) {
  MachineRig rig(routed_and_transparent());
  rig.connect(1, "192.0.2.1", kTransparent);
  for (const Example& example : printed_pairs()) {
    expect_exchange(rig, 1, example);
  }
}

TEST(PrintedPairs, GoThroughByteByByte) {
  MachineRig rig(routed_and_transparent());
  rig.connect(1);
  for (const Example& example : printed_pairs()) {
    for (std::size_t at = 0; at < example.tcp_request.size(); at += 3) {
      rig.receive(1, example.tcp_request.substr(at, 2));
      rig.advance(1ms);
    }
    ASSERT_EQ(next_frame(rig), example.rtu_request) << example.where;
    rig.advance(20ms);
    for (std::size_t at = 0; at < example.rtu_response.size(); at += 3) {
      rig.line(example.rtu_response.substr(at, 2));
    }
    EXPECT_EQ(next_adu(rig, 1), example.tcp_response) << example.where;
  }
}

TEST(PrintedPairs, GoThroughInOneSegmentBehindTheFirst) {
  Settings patient = routed_and_transparent();
  for (auto& route : patient.routes) {
    route.deadline = 60s;  // the last ones wait for all before them
  }
  MachineRig rig(patient);
  rig.connect(1);
  const auto examples = printed_pairs();
  std::string segment;
  for (const Example& example : examples) {
    segment += example.tcp_request + ' ';
  }
  const std::size_t first = examples.front().tcp_request.size();
  rig.receive(1, segment.substr(0, first));
  rig.receive(1, segment.substr(first + 1));
  for (const Example& example : examples) {
    ASSERT_EQ(next_frame(rig), example.rtu_request) << example.where;
    rig.advance(20ms);
    rig.line(example.rtu_response);
    EXPECT_EQ(next_adu(rig, 1), example.tcp_response) << example.where;
  }
}

TEST(PrintedFrames, OfAllManualsLeaveAsPrintedAndTheirResponsesComeBack) {
  const auto examples = printed_frames();
  ASSERT_EQ(examples.size(), 187U);
  MachineRig rig;
  rig.connect(1);
  for (const Example& example : examples) {
    expect_exchange(rig, 1, example);
  }
}

// Bytes 4 and 5 of an RTU frame, its quantity or value, are where the MBAP length would be: too
// large a length, a length that waits for more, or one that skips the frame.
TEST(PrintedFrames, OnTheTcpPortAreNoticedAndReachNoLine) {
  for (const Example& example : printed_pairs()) {
    MachineRig rig;
    rig.connect(1, "192.0.2.1");
    rig.connect(2, "192.0.2.2");
    rig.receive(2, example.rtu_request);
    EXPECT_EQ(next_frame(rig, 11s), "") << example.where;
    EXPECT_EQ(next_adu(rig, 2, 1s), "") << example.where;
    EXPECT_THAT(rig.events, Contains(kSpeaksRtu).Times(1)) << example.where;
    expect_undisturbed(rig, 1);
  }
}

// The stepper's line 239, a read of registers 0 and 1, is at the same time a well-formed ADU:
// transaction 0x0103, unit 196, function 11. Only its CRC gives it away.
TEST(PrintedFrames, OnTheTcpPortAreNoticedEvenWhereTheyReadAsMbap) {
  MachineRig rig;
  rig.connect(2, "192.0.2.2");
  rig.receive(2, example_at(printed_frames(), "rs485-stepper:239").rtu_request);
  rig.advance(11s);
  EXPECT_THAT(rig.events, Contains(kSpeaksRtu).Times(1));
}

}  // namespace
}  // namespace mbgate::test
