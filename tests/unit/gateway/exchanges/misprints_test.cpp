// SPDX-License-Identifier: Apache-2.0
// What the manuals print wrong goes in as printed: malformed in the ways in which real clients and
// devices are.
#include <gmock/gmock.h>

#include "unit/gateway/exchanges/printed_examples.hpp"

namespace mbgate::test {
namespace {

using testing::ElementsAre;

constexpr auto* kTimedOut = "listener plant: client 192.0.2.2 closed: a request stayed incomplete";

manuals::Misprint misprint(unsigned line) {
  const auto misprints = manuals::load_misprints();
  const auto found = std::ranges::find(misprints, line, &manuals::Misprint::line);
  if (found == misprints.end()) {
    throw std::runtime_error("no misprint at line " + std::to_string(line));
  }
  return *found;
}

/// The example whose request stands on the line before the TCP ADU at `line`.
Example pair_of(unsigned line) {
  return example_at(printed_pairs(), "moons-drives:" + std::to_string(line - 1));
}

/// Client 2 is the one that sends something wrong, client 1 the one that must not notice.
void connect_both(MachineRig& rig) {
  rig.connect(1, "192.0.2.1");
  rig.connect(2, "192.0.2.2");
}

// Line 636 prints a length that is two bytes too long: the gateway waits for them, and gives up.
TEST(Misprints, ALengthTooLongWaitsAndIsClosed) {
  MachineRig rig;
  connect_both(rig);
  rig.receive(2, hex(misprint(636).printed));
  EXPECT_EQ(next_frame(rig, 5s), "");
  EXPECT_FALSE(rig.closed.contains(2));
  expect_undisturbed(rig, 1);
  rig.advance(5s);
  EXPECT_TRUE(rig.closed.contains(2));
  EXPECT_THAT(rig.events, ElementsAre(kTimedOut));
  EXPECT_EQ(next_adu(rig, 2, 1s), "");
  expect_undisturbed(rig, 1);
}

// The request that follows loses its first two bytes to the ADU before it. That one no longer fits
// its function (03), and the rest of the stream cannot be followed.
TEST(Misprints, ALengthTooLongSpoilsTheRequestThatFollows) {
  MachineRig rig;
  connect_both(rig);
  rig.receive(2, hex(misprint(636).printed) + ' ' + printed_pairs().front().tcp_request);
  EXPECT_EQ(next_adu(rig, 2), "00 00 00 00 00 03 01 90 03");
  EXPECT_TRUE(rig.closed.contains(2));
  EXPECT_THAT(
      rig.events,
      ElementsAre("listener plant: client 192.0.2.2 closed: MBAP length 259 is not 2 to 254"));
  EXPECT_EQ(next_frame(rig, 1s), "");
  expect_undisturbed(rig, 1);
}

// Lines 608 and 622 print one byte too many within the data. The ADU that the length field cuts out
// is well formed and goes on the wire; one byte is left over and never becomes a request.
TEST(Misprints, AnExtraByteIsLeftOverAndTimesOut) {
  for (const unsigned line : {608U, 622U}) {
    const auto printed = misprint(line).printed;
    Example cut = pair_of(line);
    cut.tcp_request = hex(printed);
    cut.rtu_request = rtu_of(modbus::Bytes(printed).subspan(6, printed.size() - 7));
    MachineRig rig;
    connect_both(rig);
    expect_exchange(rig, 2, cut);
    expect_undisturbed(rig, 1);
    EXPECT_FALSE(rig.closed.contains(2)) << line;
    rig.advance(10s);
    EXPECT_TRUE(rig.closed.contains(2)) << line;
    EXPECT_THAT(rig.events, ElementsAre(kTimedOut)) << line;
    EXPECT_EQ(next_frame(rig, 1s), "") << line;
    expect_undisturbed(rig, 1);
  }
}

TEST(Misprints, AnExtraByteLosesTheFramingOfTheRequestThatFollows) {
  for (const unsigned line : {608U, 622U}) {
    MachineRig rig;
    connect_both(rig);
    rig.receive(2, hex(misprint(line).printed));
    EXPECT_NE(next_frame(rig), "") << line;
    rig.receive(2, printed_pairs().front().tcp_request);
    EXPECT_TRUE(rig.closed.contains(2)) << line;
    EXPECT_THAT(
        rig.events,
        ElementsAre("listener plant: client 192.0.2.2 closed: MBAP length 0 is not 2 to 254"))
        << line;
    // What is on the wire goes on; its response has nobody to go to.
    rig.advance(20ms);
    rig.line(pair_of(line).rtu_response);
    EXPECT_EQ(next_adu(rig, 2, 1s), "") << line;
    EXPECT_EQ(next_frame(rig, 1s), "") << line;
    expect_undisturbed(rig, 1);
  }
}

// An echo with a wrong CRC or cut short is no answer: the write may have been done (0B). It is not
// repeated.
TEST(Misprints, ADamagedResponseIsNoAnswer) {
  for (const unsigned line : {1053U, 1508U, 1535U, 1633U}) {
    const manuals::Misprint damaged = misprint(line);
    MachineRig rig;
    connect_both(rig);
    expect_exchange(rig, 2,
                    {damaged.where(), tcp_of(damaged.right), hex(damaged.right),
                     hex(damaged.printed), "00 00 00 00 00 03 01 86 0B"});
    EXPECT_EQ(next_frame(rig, 3s), "") << line;
    expect_undisturbed(rig, 1);
  }
}

// Line 1555 prints one byte behind the frame: the response is complete before it comes.
TEST(Misprints, AByteBehindAResponseIsIgnored) {
  Example example = example_at(printed_frames(), "rs485-stepper:1554");
  const manuals::Misprint longer = misprint(1555);
  EXPECT_EQ(example.rtu_response, hex(longer.right));
  example.rtu_response = hex(longer.printed);
  MachineRig rig;
  connect_both(rig);
  expect_exchange(rig, 2, example);
  expect_undisturbed(rig, 2);
  expect_undisturbed(rig, 1);
}

}  // namespace
}  // namespace mbgate::test
