// SPDX-License-Identifier: Apache-2.0
// What a trace says of lines on which it is not plain which bytes belong together.
#include <gmock/gmock.h>

#include "gateway/trace/trace_book.hpp"
#include "unit/gateway/trace/trace_lines.hpp"

namespace mbgate::test {
namespace {

using testing::ElementsAre;

Settings one_connection() {
  Settings settings = one_axis();
  settings.buses[0].line.framing = bus::Framing::tcp;
  settings.buses[0].line.remote = bus::Endpoint{"192.0.2.50"};
  settings.buses[0].outstanding = 2;
  return settings;
}

Settings broadcasting() {
  Settings settings = one_axis();
  settings.listeners[0].bus = BusId{0};
  settings.listeners[0].broadcast = true;
  settings.routes.clear();
  return settings;
}

// The echo of a broadcast comes when the bus waits for nothing any more.
TEST(TraceOfABroadcast, ItsEchoIsNotCalledUnasked) {
  MachineRig rig{broadcasting()};
  rig.connect(1);
  rig.harness.gateway().set_traced(true);
  rig.receive(1, "0007 0000 0006 00 06 0000 0001");
  rig.advance(150ms);
  rig.line("00 06 00 00 00");
  rig.advance(1ms);
  rig.line("01 49 DB");
  rig.advance(100ms);
  rig.line("55");
  rig.advance(100ms);
  const Lines all = taken_lines(rig);
  EXPECT_THAT(
      all, ElementsAre("00 07 00 00 00 06 00 06 00 00 00 01 = 00 07 00 00 00 06 00 06 00 00 00 01"
                       " / line-a > 00 06 00 00 00 01 49 DB < sent",
                       "= / line-a >  < 55 unasked"));
}

// A length that is too large: the answer never becomes whole.
TEST(TraceOfAConnection, ShowsWhatIsNoWholeAdu) {
  Settings settings = one_axis();
  settings.devices[0].timing.retries = 0;
  settings.buses[0].line.framing = bus::Framing::tcp;
  settings.buses[0].line.remote = bus::Endpoint{"192.0.2.50"};
  MachineRig rig{settings};
  rig.connect(1);
  rig.harness.gateway().set_traced(true);
  rig.receive(1, read_request(7, 1));
  rig.advance(5ms);
  const auto sent = rig.take_transmitted();
  ASSERT_EQ(sent.size(), 1U);
  rig.line(sent[0].substr(0, 5) + " 00 00 00 06 01 03 02 00 01");
  rig.advance(500ms);
  const auto taken = rig.harness.gateway().take_trace(rig.now());
  ASSERT_EQ(taken.records.size(), 1U);
  EXPECT_EQ(text(taken.records[0].wire[0]), " / line-a axis> " + sent[0] + " < " +
                                                sent[0].substr(0, 5) +
                                                " 00 00 00 06 01 03 02 00 01 no response");
}

// The answers come in the other order, in one piece and a half.
TEST(TraceOfAConnection, FindsTheAdusOfEachTransaction) {
  MachineRig rig{one_connection()};
  rig.connect(1);
  rig.harness.gateway().set_traced(true);
  rig.receive(1, read_request(7, 1) + read_request(8, 2));
  rig.advance(5ms);
  const auto sent = rig.take_transmitted();
  ASSERT_EQ(sent.size(), 2U);
  const std::string first = sent[0].substr(0, 5);
  const std::string second = sent[1].substr(0, 5);
  rig.line(second + " 00 00 00 05 02 03 02 00 02 " + first + " 00 00 00");
  rig.line("05 01 03 02 00 01");
  const Lines all = taken_lines(rig);
  EXPECT_THAT(all,
              ElementsAre("00 08 00 00 00 06 02 03 00 00 00 01 = 00 08 00 00 00 05 02 03 02 00 02"
                          " / line-a > " +
                              sent[1] + " < " + second + " 00 00 00 05 02 03 02 00 02 answered",
                          "00 07 00 00 00 06 01 03 00 00 00 01 = 00 07 00 00 00 05 01 03 02 00 01"
                          " / line-a axis> " +
                              sent[0] + " < " + first + " 00 00 00 05 01 03 02 00 01 answered"));
}

}  // namespace
}  // namespace mbgate::test
