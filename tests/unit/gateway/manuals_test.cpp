// SPDX-License-Identifier: Apache-2.0
// The printed frames of the drive manuals driven through the machine: the TCP message in, exactly
// the RTU bytes out; the RTU response in, exactly the TCP message out.
#include <gtest/gtest.h>

#include "unit/gateway/printed_examples.hpp"

namespace mbgate::gateway::printed {
namespace {

TEST(PrintedPairs, GoThroughARouteAndBack) {
  const auto examples = printed_pairs();
  ASSERT_EQ(examples.size(), 37U);
  Bench bench;
  const ClientId client = bench.connect(kRouted);
  for (const Example& example : examples) {
    expect_exchange(bench, client, example);
  }
  EXPECT_TRUE(bench.next_adu(client, seconds(1)).empty());
  EXPECT_TRUE(bench.next_frame(seconds(1)).empty());
}

TEST(PrintedPairs, GoThroughATransparentListenerAndBack) {
  Bench bench;
  const ClientId client = bench.connect(kTransparent);
  for (const Example& example : printed_pairs()) {
    expect_exchange(bench, client, example);
  }
}

TEST(PrintedPairs, GoThroughByteByByte) {
  Bench bench;
  const ClientId client = bench.connect(kRouted);
  for (const Example& example : printed_pairs()) {
    for (const std::uint8_t byte : example.tcp_request) {
      bench.from_client(client, {&byte, 1});
      bench.advance(milliseconds(1));
    }
    ASSERT_EQ(bench.next_frame(), example.rtu_request) << example.where;
    bench.advance(milliseconds(50));
    for (const std::uint8_t byte : example.rtu_response) {
      bench.from_line({&byte, 1});
    }
    EXPECT_EQ(bench.next_adu(client), example.tcp_response) << example.where;
  }
}

TEST(PrintedPairs, GoThroughAllInOneSegment) {
  Bench bench;
  const ClientId client = bench.connect(kRouted);
  const auto examples = printed_pairs();
  ByteList stream;
  for (const Example& example : examples) {
    stream.insert(stream.end(), example.tcp_request.begin(), example.tcp_request.end());
  }
  bench.from_client(client, stream);
  for (const Example& example : examples) {
    ASSERT_EQ(bench.next_frame(), example.rtu_request) << example.where;
    bench.advance(milliseconds(20));
    bench.from_line(example.rtu_response);
    EXPECT_EQ(bench.next_adu(client), example.tcp_response) << example.where;
  }
}

TEST(PrintedFrames, EveryPrintedRequestLeavesAsPrintedAndItsResponseComesBack) {
  const auto frames = manuals::load_rtu();
  Bench bench;
  const ClientId client = bench.connect(kRouted);
  std::size_t count = 0;
  for (const manuals::Frame& frame : frames) {
    if (frame.direction == manuals::Direction::response) {
      continue;
    }
    const auto answer = std::ranges::find_if(frames, [&](const manuals::Frame& other) {
      return other.manual == frame.manual && other.answers == frame.line;
    });
    Example example{frame.where(), frame.bytes, tcp_of(frame.bytes), {}, {}};
    example.rtu_response = answer != frames.end() ? answer->bytes : vendor_exception(frame.bytes);
    example.tcp_response = tcp_of(example.rtu_response);
    expect_exchange(bench, client, example);
    ++count;
  }
  EXPECT_EQ(count, 187U);
}

// Line 636 prints a length that is two bytes too long: the gateway waits for them, and gives up.

// The request that follows loses its first two bytes to the ADU before it. That one no longer fits

// its function (03), and the rest of the stream cannot be followed.

// Lines 608 and 622 print one byte too many within the data. The ADU that the length field cuts out

// is well formed and goes on the wire; one byte is left over and never becomes a request.

// An echo with a wrong CRC or cut short is no answer: the write may have been done (0B). It is not

// repeated.

// Line 1555 prints one byte behind the frame: the response is complete before it comes.

// RTU frames sent to the TCP port: nothing reaches the line, one event says what it was.

TEST(PrintedFrames, OnTheTcpPortAreNoticedAndReachNoLine) {
  Bench bench;
  const ClientId other = bench.connect(kRouted);
  for (const Example& example : printed_pairs()) {
    const std::size_t before = bench.events<ClientSpeaksRtu>();
    const ClientId client = bench.connect(kRouted);
    bench.from_client(client, example.rtu_request);
    EXPECT_TRUE(bench.next_frame(seconds(11)).empty()) << example.where;
    EXPECT_TRUE(bench.next_adu(client, seconds(1)).empty()) << example.where;
    EXPECT_EQ(bench.events<ClientSpeaksRtu>(), before + 1) << example.where;
  }
  expect_undisturbed(bench, other);
}

// The stepper's line 239, a read of registers 0 and 1, is at the same time a well-formed ADU:

// transaction 0x0103, unit 196, function 11. Only its CRC gives it away.

TEST(PrintedFrames, OnTheTcpPortAreNoticedEvenWhereTheyReadAsMbap) {
  const auto frames = manuals::load_rtu();
  const auto frame = std::ranges::find_if(frames, [](const manuals::Frame& candidate) {
    return candidate.manual == "rs485-stepper" && candidate.line == 239;
  });
  ASSERT_NE(frame, frames.end());
  Bench bench;
  bench.from_client(bench.connect(kRouted), frame->bytes);
  bench.advance(seconds(11));
  EXPECT_EQ(bench.events<ClientSpeaksRtu>(), 1U);
}

}  // namespace
}  // namespace mbgate::gateway::printed
