// SPDX-License-Identifier: Apache-2.0
// A bus in ASCII, 7 data bits at 19200 baud: 17 characters take 8.854 ms.
#include "unit/bus/bus_rig.hpp"

namespace mbgate::test {
namespace {

constexpr auto kAsciiEmission = 8854167ns;  // 170 bits, rounded up
constexpr auto kAsciiRead = ":010300000001FB\r\n";
constexpr auto kAsciiAnswer = ":0103021234B4\r\n";

class BusAscii : public Bus {
 protected:
  static bus::BusSettings ascii() {
    auto ascii = settings();
    ascii.line.framing = bus::Framing::ascii;
    ascii.line.format.data_bits = 7;
    return ascii;
  }
  void text(std::string_view characters) {
    bus_->handle_bytes(
        {reinterpret_cast<const std::uint8_t*>(characters.data()), characters.size()}, now_);
    drain();
  }
  [[nodiscard]] std::vector<std::string> texts() const {
    std::vector<std::string> texts;
    for (const std::string& frame : frames_) {
      const auto bytes = unhex(frame);
      texts.emplace_back(bytes.begin(), bytes.end());
    }
    return texts;
  }
};

TEST_F(BusAscii, AsksAndIsAnswered) {
  open(ascii());
  bus::Job& read = job(kRead);
  submit(read);
  EXPECT_THAT(texts(), ElementsAre(kAsciiRead));
  advance(20ms);
  text(kAsciiAnswer);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  EXPECT_EQ(hex(read.transactions[0].response->bytes()), "03 02 12 34");
  EXPECT_EQ(bus_->devices()[1].counters.noise_bytes, 0U);
}

TEST_F(BusAscii, BehindADamagedAnswerTheLineIsDrained) {
  open(ascii());
  submit(job(kRead));
  advance(20ms);
  text(":0103021234B5\r\n");
  EXPECT_EQ(bus_->parts().line.state(now_), bus::LineState::draining);
  advance(5ms);
  EXPECT_EQ(bus_->parts().line.state(now_), bus::LineState::idle);
}

// Whoever it is for: the next request does not go into it.
TEST_F(BusAscii, WaitsUntilAFrameThatPausesIsOver) {
  open(ascii());
  advance(1s);
  text(":0203021");
  submit(job(kRead));
  advance(19ms);
  EXPECT_THAT(frames_, IsEmpty());
  advance(10ms);
  EXPECT_THAT(texts(), ElementsAre(kAsciiRead));
}

TEST_F(BusAscii, AReadShowsThatThereIsNoEchoOnlyIfNothingComesBeforeItsAnswer) {
  auto learning = ascii();
  learning.line.echo = std::nullopt;
  for (const std::string before : {"", ":010300000001FC\r\n", "\r\n", ":0103"}) {
    faults_.clear();
    open(learning);
    submit(job(kRead));
    advance(20ms);
    text(before + kAsciiAnswer);
    advance(10ms);
    submit(job("06 0000 0001"));
    advance(20ms);
    text(":010600000001F8\r\n");
    EXPECT_EQ(faults_, std::vector(before.empty() ? 0U : 1U, bus::LineFault::echo_unproven))
        << before;
    advance(10ms);
  }
}

// The specification asks ASCII for none; a drive may still hold the line after its line feed.
TEST_F(BusAscii, KeepsTheSilenceOfRtu) {
  open(ascii());
  submit(job(kRead));
  submit(job(kRead));
  advance(20ms);
  text(kAsciiAnswer);
  EXPECT_EQ(until_next_frame(), 1822917ns);  // 35 bits, rounded up
}

TEST_F(BusAscii, ABabblingLineDoesNotHoldTheBusForEver) {
  open(ascii());
  submit(job(kRead));
  const Instant start = now_;
  for (int step = 0; step < 100 && endings_.empty(); ++step) {
    advance(100ms);
    text(":01");
  }
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
  EXPECT_LE(now_ - start, 1500ms);  // the timeout, the longest frame, and one second
}

TEST_F(BusAscii, KeepsAFrameGapThatIsAskedFor) {
  auto gapped = ascii();
  gapped.frame_gap = 5ms;
  open(gapped);
  submit(job(kRead));
  submit(job(kRead));
  advance(20ms);
  text(kAsciiAnswer);
  EXPECT_EQ(until_next_frame(), 5ms);
}

TEST_F(BusAscii, CountsTheCharactersOfAFrame) {
  open(ascii());
  submit(job(kRead));
  const Instant start = now_;
  EXPECT_EQ(next_deadline(), start + kAsciiEmission + 100ms);
  advance(1s);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
  EXPECT_EQ(ended_at_[0] - start, kAsciiEmission + 100ms);
}

TEST_F(BusAscii, CountsEightDataBitsToo) {
  auto eight = ascii();
  eight.line.format.data_bits = 8;
  open(eight);
  submit(job(kRead));
  EXPECT_EQ(next_deadline(), now_ + 9739584ns + 100ms);  // 187 bits
}

TEST_F(BusAscii, AnAnswerThatBeganInTimeHasASecondForAllOfItsCharacters) {
  for (const Duration gap : {66ms, 600ms}) {
    endings_.clear();
    ended_at_.clear();
    open(ascii());
    submit(job(kRead));
    advance(kAsciiEmission + 99ms);
    const Instant began = now_;
    for (const char character : std::string_view(kAsciiAnswer)) {
      text({&character, 1});
      advance(gap);
    }
    ASSERT_THAT(endings_, ElementsAre(gap == 66ms ? Ending::answered : Ending::no_answer));
    EXPECT_LE(ended_at_[0] - began, 1020ms);  // not 9 s
  }
}

TEST_F(BusAscii, AStopWaitsForOneThatHasBegunNoLongerThanTheSlack) {
  auto axes = ascii();
  axes.timing.response_timeout = 1s;
  drive::Device axis{"axis", {}, 2, axes.timing};
  axis.profile.stops = {{.address = 0, .value = 1}};
  open(axes, {axis});
  submit(job(kRead));
  advance(kAsciiEmission + 50ms);
  text(":01");
  submit(job("06 0000 0001", 2));
  const Instant since = now_;
  for (int pieces = 0; pieces < 10; ++pieces) {
    advance(50ms);
    text("0");
  }
  ASSERT_THAT(frames_, SizeIs(2));
  EXPECT_LE(frame_times_[1] - since, 150ms);
}

TEST_F(BusAscii, AnAnswerThatStopsHalfWayEndsTheWaitAfterASecond) {
  open(ascii());
  submit(job(kRead));
  advance(50ms);
  text(":0103");
  const Instant last = now_;
  advance(5s);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
  EXPECT_EQ(ended_at_[0] - last, 1s);
}

TEST_F(BusAscii, AFrameOfAnotherUnitDoesNotProlongTheWait) {
  open(ascii());
  submit(job(kRead));
  const Instant start = now_;
  advance(kAsciiEmission + 90ms);
  text(":0203");
  advance(1s);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
  EXPECT_EQ(ended_at_[0] - start, kAsciiEmission + 100ms);
}

TEST_F(BusAscii, ABadLrcIsRetriedForReadsOnly) {
  auto retrying = ascii();
  retrying.timing.retries = 1;
  open(retrying);
  submit(job(kRead));
  advance(20ms);
  text(":0103021235B4\r\n");
  advance(5ms);
  EXPECT_THAT(texts(), ElementsAre(kAsciiRead, kAsciiRead));
  advance(20ms);
  text(kAsciiAnswer);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  advance(200ms);  // its quarantine
  submit(job("06 0000 0001"));
  advance(20ms);
  text(":010600000001F7\r\n");
  EXPECT_EQ(endings_.back(), Ending::no_answer);
  EXPECT_EQ(bus_->counters().bad_crcs, 2U);
  EXPECT_EQ(bus_->devices()[1].counters.bad_crcs, 2U);
}

TEST_F(BusAscii, ReadsAndComparesItsEcho) {
  auto echoing = ascii();
  echoing.line.echo = true;
  open(echoing);
  submit(job("06 0000 0001"));  // its answer looks like its echo
  text(":0106000");
  text("00001F8\r\n");
  EXPECT_THAT(endings_, IsEmpty());
  text(":010600000001F8\r\n");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  EXPECT_EQ(bus_->counters().echo_mismatches, 0U);
}

TEST_F(BusAscii, ReadsTheEchoOfTheLongestFrame) {
  auto echoing = ascii();
  echoing.line.echo = true;
  open(echoing);
  std::string request = "46";
  for (int byte = 0; byte < 252; ++byte) {
    request += "00";
  }
  submit(job(request));
  ASSERT_EQ(texts().at(0).size(), modbus::kMaxAsciiSize);
  text(texts()[0]);
  text(":0146AABBCC88\r\n");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
}

TEST_F(BusAscii, BroadcastsKeepTheTurnaroundDelay) {
  open(ascii());
  submit(job("06 0000 0001", 0));
  submit(job(kRead));
  const Instant start = now_;
  advance(kAsciiEmission + 100ms);
  EXPECT_THAT(texts(), ElementsAre(":000600000001F9\r\n", kAsciiRead));
  EXPECT_EQ(ended_at_.at(0) - start, kAsciiEmission);
  EXPECT_EQ(frame_times_[1] - start, kAsciiEmission + 100ms);
}

}  // namespace
}  // namespace mbgate::test
