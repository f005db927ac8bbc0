// SPDX-License-Identifier: Apache-2.0
// The wire in ASCII mode, 10000 baud 7N2: a character takes 1 ms.
#include <gmock/gmock.h>

#include "sim/wire/wire.hpp"

namespace mbgate::test {
namespace {

using namespace std::chrono_literals;
using bus::Instant;
using sim::Duration;

/// Read status code of MOONS' manual (5.1) in ASCII.
constexpr auto kRequest = ":010300010001FA\r\n";
constexpr auto kAnswer = ":0103020009F1\r\n";

class AsciiWire : public testing::Test {
 protected:
  void transmit(std::string_view text, Duration at) {
    wire_.transmit(std::vector<std::uint8_t>(text.begin(), text.end()), Instant(at));
  }
  std::string run() {
    std::string received;
    while (const auto at = wire_.next_event()) {
      const auto bytes = wire_.advance(*at);
      if (received.empty() && !bytes.empty()) {
        first_ = at->time_since_epoch();
      }
      received.append(bytes.begin(), bytes.end());
    }
    return received;
  }
  [[nodiscard]] const sim::WireCounters& counters() const { return wire_.counters(); }

  Duration first_{};  ///< when the first character came
  sim::Wire wire_{{.baud = modbus::Baud{10000},
                   .format = {7, modbus::Parity::none, 2},
                   .framing = sim::Framing::ascii,
                   .chunk = 0ms,
                   .frames_kept = 10},
                  {{.address = 1}}};
};

TEST_F(AsciiWire, AnswersInAsciiWithoutAnySilence) {
  transmit(kRequest, 0ms);
  EXPECT_EQ(run(), kAnswer);
  EXPECT_EQ(first_, 17ms + 1ms + 1ms);  // the request, processing, the first character
  ASSERT_EQ(wire_.frames().size(), 1U);
  EXPECT_TRUE(wire_.frames()[0].intact);
  EXPECT_EQ(wire_.frames()[0].end, Instant(17ms));
}

TEST_F(AsciiWire, CountsNoViolationsOfASilenceThatIsNotAskedFor) {
  transmit(kRequest, 0ms);
  run();
  transmit(kRequest, 33ms);  // at once after the answer's last character
  EXPECT_EQ(run(), kAnswer);
  EXPECT_EQ(counters(), (sim::WireCounters{.frames = 2, .answers = 2}));
}

TEST_F(AsciiWire, PutsTogetherWhatComesInParts) {
  transmit(":01030001", 0ms);
  run();
  transmit("0001FA\r", 900ms);
  run();
  transmit("\n", 1500ms);
  EXPECT_EQ(run(), kAnswer);
  EXPECT_EQ(counters(), (sim::WireCounters{.frames = 1, .answers = 1}));
  EXPECT_EQ(wire_.frames()[0].begin, Instant(0ms));
}

TEST_F(AsciiWire, BeginsAnewWithAColon) {
  transmit(":0106007C00", 0ms);
  transmit(kRequest, 20ms);
  EXPECT_EQ(run(), kAnswer);
  EXPECT_EQ(counters(), (sim::WireCounters{.frames = 2, .answers = 1, .bad_crc = 1}));
}

TEST_F(AsciiWire, NeverAnswersAWrongLrcOrAnRtuFrame) {
  transmit(":010300010001FB\r\n", 0ms);
  EXPECT_EQ(run(), "");
  wire_.transmit(std::vector<std::uint8_t>{1, 3, 0, 1, 0, 1, 0xD5, 0xCA}, Instant(1s));
  EXPECT_EQ(run(), "");
  EXPECT_EQ(counters(), (sim::WireCounters{.frames = 1, .bad_crc = 1}));
}

TEST_F(AsciiWire, CarriesSevenBits) {
  std::string marked(kRequest);
  marked[3] = static_cast<char>(marked[3] | '\x80');
  transmit(marked, 0ms);
  EXPECT_EQ(run(), kAnswer);
}

TEST_F(AsciiWire, CarriesFaultyAnswers) {
  wire_.device(1)->set_faults({.bad_crc = true});
  transmit(kRequest, 0ms);
  EXPECT_EQ(run(), ":0103020009F0\r\n");
  wire_.device(1)->set_faults({.wrong_unit = true});
  transmit(kRequest, 1s);
  EXPECT_EQ(run(), ":0203020009F0\r\n");
}

TEST_F(AsciiWire, ForgetsHalfAFrameWhenTheAdapterVanishes) {
  transmit(":01030001", 0ms);
  wire_.advance(Instant(10ms));
  wire_.disconnect();
  transmit("0001FA\r\n", 20ms);
  EXPECT_EQ(run(), "");
  EXPECT_EQ(counters().frames, 0U);
}

}  // namespace
}  // namespace mbgate::test
