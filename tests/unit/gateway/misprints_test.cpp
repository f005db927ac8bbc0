// SPDX-License-Identifier: Apache-2.0
// What the manuals print wrong goes in as printed: malformed in the ways in which real clients and
// devices are.
#include <gtest/gtest.h>

#include "unit/gateway/printed_examples.hpp"

namespace mbgate::gateway::printed {
namespace {

manuals::Misprint misprint(unsigned line) {
  const auto misprints = manuals::load_misprints();
  const auto found = std::ranges::find(misprints, line, &manuals::Misprint::line);
  if (found == misprints.end()) {
    throw std::runtime_error("no misprint at line " + std::to_string(line));
  }
  return *found;
}

TEST(Misprints, ALengthTooLongWaitsAndIsClosed) {
  Bench bench;
  const ClientId client = bench.connect(kRouted);
  const ClientId other = bench.connect(kRouted);
  bench.from_client(client, misprint(636).printed);
  EXPECT_TRUE(bench.next_frame(seconds(5)).empty());
  EXPECT_FALSE(bench.is_closed(client));
  expect_undisturbed(bench, other);
  bench.advance(seconds(5));
  EXPECT_TRUE(bench.is_closed(client));
  EXPECT_EQ(bench.events<ClientFrameTimedOut>(), 1U);
  EXPECT_TRUE(bench.next_adu(client, seconds(1)).empty());
  expect_undisturbed(bench, other);
}

TEST(Misprints, ALengthTooLongSpoilsTheRequestThatFollows) {
  Bench bench;
  const ClientId client = bench.connect(kTransparent);
  const ClientId other = bench.connect(kTransparent);
  ByteList stream = misprint(636).printed;
  const ByteList next = printed_pair(261).tcp_request;
  stream.insert(stream.end(), next.begin(), next.end());
  bench.from_client(client, stream);
  EXPECT_EQ(bench.next_adu(client), (ByteList{0, 0, 0, 0, 0, 3, 1, 0x90, 0x03}));
  EXPECT_TRUE(bench.is_closed(client));
  EXPECT_EQ(bench.events<ClientFramingLost>(), 1U);
  EXPECT_TRUE(bench.next_frame(seconds(1)).empty());
  expect_undisturbed(bench, other);
}

TEST(Misprints, AnExtraByteIsLeftOverAndTimesOut) {
  for (const unsigned line : {608U, 622U}) {
    const ByteList printed = misprint(line).printed;
    Bench bench;
    const ClientId client = bench.connect(kRouted);
    const ClientId other = bench.connect(kRouted);
    const Example cut{"", rtu_of(1, {printed.begin() + 7, printed.end() - 1}), printed,
                      printed_pair(line - 1).rtu_response, printed_pair(line - 1).tcp_response};
    expect_exchange(bench, client, cut);
    expect_undisturbed(bench, other);
    EXPECT_FALSE(bench.is_closed(client));
    bench.advance(seconds(10));
    EXPECT_TRUE(bench.is_closed(client)) << line;
    EXPECT_EQ(bench.events<ClientFrameTimedOut>(), 1U) << line;
    EXPECT_TRUE(bench.next_frame(seconds(1)).empty()) << line;
    expect_undisturbed(bench, other);
  }
}

TEST(Misprints, AnExtraByteLosesTheFramingOfTheRequestThatFollows) {
  for (const unsigned line : {608U, 622U}) {
    const Example right = printed_pair(line - 1);
    Bench bench;
    const ClientId client = bench.connect(kRouted);
    const ClientId other = bench.connect(kRouted);
    bench.from_client(client, misprint(line).printed);
    EXPECT_FALSE(bench.next_frame().empty()) << line;
    bench.from_client(client, printed_pair(261).tcp_request);
    EXPECT_TRUE(bench.is_closed(client)) << line;
    EXPECT_EQ(bench.events<ClientFramingLost>(), 1U) << line;
    // What is on the wire goes on; its response has nobody to go to.
    bench.advance(milliseconds(50));
    bench.from_line(right.rtu_response);
    EXPECT_TRUE(bench.next_adu(client, seconds(1)).empty()) << line;
    EXPECT_TRUE(bench.next_frame(seconds(1)).empty()) << line;
    expect_undisturbed(bench, other);
  }
}

TEST(Misprints, ADamagedResponseIsNoAnswer) {
  for (const unsigned line : {1053U, 1508U, 1535U, 1633U}) {
    const manuals::Misprint damaged = misprint(line);
    Bench bench;
    const ClientId client = bench.connect(kRouted);
    const ClientId other = bench.connect(kRouted);
    const Example example{damaged.where(),
                          damaged.right,
                          tcp_of(damaged.right),
                          damaged.printed,
                          {0, 0, 0, 0, 0, 3, 1, 0x86, 0x0B}};
    expect_exchange(bench, client, example);
    EXPECT_TRUE(bench.next_frame(seconds(3)).empty()) << line;
    expect_undisturbed(bench, other);
  }
}

TEST(Misprints, AByteBehindAResponseIsIgnored) {
  const manuals::Misprint longer = misprint(1555);
  const auto frames = manuals::load_rtu();
  const auto request = std::ranges::find_if(frames, [](const manuals::Frame& frame) {
    return frame.manual == "rs485-stepper" && frame.line == 1554;
  });
  ASSERT_NE(request, frames.end());
  Bench bench;
  const ClientId client = bench.connect(kRouted);
  expect_exchange(bench, client,
                  {longer.where(), request->bytes, tcp_of(request->bytes), longer.printed,
                   tcp_of(longer.right)});
  expect_undisturbed(bench, client);
}

}  // namespace
}  // namespace mbgate::gateway::printed
