// SPDX-License-Identifier: Apache-2.0
// The times of a bus: silence, gaps, timeouts, settling.
#include "unit/bus/bus_rig.hpp"

namespace mbgate::test {
namespace {

TEST_F(Bus, KeepsT35AfterAnAnswer) {
  open(settings());
  submit(job(kRead));
  submit(job(kRead));
  advance(20ms);
  line(kAnswer);
  EXPECT_EQ(until_next_frame(), kT35);
}

TEST_F(Bus, AFrameGapMayBeShorterThanT35) {
  auto shorter = settings();
  shorter.frame_gap = 0ms;
  open(shorter);
  submit(job(kRead));
  submit(job(kRead));
  advance(20ms);
  line(kAnswer);
  EXPECT_THAT(frames_, SizeIs(2));
}

TEST_F(Bus, KeepsTheGapOfADeviceOnTopOfT35) {
  drive::Device slow{"slow", {}, 1, settings().timing};
  slow.timing.gap = 30ms;
  open(settings(), {slow});
  advance(100ms);
  submit(job(kRead, 2));
  submit(job(kRead, 1));
  advance(20ms);
  line("02 03 02 12 34 F1 33");
  EXPECT_EQ(until_next_frame(), kT35 + 30ms);
}

TEST_F(Bus, WaitsForSilenceWhileTheLineBabbles) {
  open(settings());
  bus::Job& waiting = job(kRead);
  for (int byte = 0; byte < 20; ++byte) {
    line("55");
    if (byte == 0) {
      submit(waiting);
    }
    advance(1ms);
    EXPECT_THAT(frames_, IsEmpty());
  }
  EXPECT_EQ(until_next_frame(), kT35 - 1ms);
}

TEST_F(Bus, NeverTransmitsIntoItsOwnFrame) {
  open(settings());
  submit(job(kRead));
  submit(job(kRead));
  line(kAnswer);  // a stranger's bytes that happen to fit, while our frame is still on its way
  EXPECT_EQ(until_next_frame(), kEmission + kT35);
}

TEST_F(Bus, TheResponseTimeoutRunsFromTheEndOfTheTransmission) {
  open(settings());
  submit(job(kRead));
  const Instant start = now_;
  advance(1s);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
  EXPECT_EQ(ended_at_[0] - start, kEmission + 100ms);
}

TEST_F(Bus, TheResponseWaitOfADeviceIsAddedToItsTimeout) {
  drive::Device aic{"aic", {}, 1, settings().timing};
  aic.timing.response_wait = 20ms;
  open(settings(), {aic});
  submit(job(kRead));
  const Instant start = now_;
  advance(1s);
  EXPECT_EQ(ended_at_.at(0) - start, kEmission + 120ms);
}

TEST_F(Bus, AnAnswerMayEndAfterTheTimeoutIfItBeganBefore) {
  open(settings());
  submit(job(kRead));
  advance(kEmission + 99ms);
  line("01 03");
  advance(10ms);
  line("02 12 34 B5 33");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
}

TEST_F(Bus, AnAnswerThatStopsHalfWayEndsTheWait) {
  open(settings());
  submit(job(kRead));
  advance(kEmission + 99ms);
  line("01 03 02");
  advance(30ms);  // seven characters take 4.01 ms, plus 20 ms
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
}

class BusPauses : public Bus {
 protected:
  /// A read whose answer begins so long after it has left, and pauses.
  void read_with_pause(Duration pause, Duration began = 99ms) {
    submit(job(kRead));
    advance(kEmission + began);
    line("01 03 02");
    advance(pause);
    line("12 34 B5 33");
  }
};

// A Wi-Fi device server passes an answer on in parts.
TEST_F(BusPauses, AnAnswerMayPauseLongerBehindADeviceServer) {
  auto remote = settings();
  remote.line.remote = bus::Endpoint{"wifi", 4001};
  open(remote);
  read_with_pause(150ms, 50ms);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
}

TEST_F(BusPauses, FrameSlackSaysHowLongAnAnswerMayPause) {
  auto slack = settings();
  slack.frame_slack = 60ms;
  open(slack);
  read_with_pause(60ms);
  slack.frame_slack = 30ms;
  update(slack, {});
  advance(5ms);
  read_with_pause(60ms);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::no_answer));
}

TEST_F(Bus, CountsGlitchesBeforeTheAnswersOfADevice) {
  open(settings());
  submit(job(kRead));
  advance(20ms);
  line("FE F8 01 03 02 12 34 B5 33");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  EXPECT_EQ(bus_->devices()[1].counters.noise_bytes, 2U);
  EXPECT_EQ(bus_->counters().noise_bytes, 2U);
  submit(job(kRead));
  time_out();
  EXPECT_EQ(bus_->counters().noise_bytes, 2U) << "nothing came";
}

TEST_F(Bus, SettlesAfterATimeoutBeforeTheNextRequest) {
  auto settling = settings();
  settling.settle = 50ms;
  open(settling);
  submit(job(kRead));
  submit(job(kRead, 2));
  time_out();
  EXPECT_EQ(until_next_frame(), 50ms);
}

TEST_F(Bus, OnlyTheEndOfASilenceMayBeWokenForEarly) {
  open(settings());
  line(kAnswer);
  submit(job(kRead));
  EXPECT_TRUE(bus_->next_wake()->ends_silence);
  advance(5ms);
  EXPECT_FALSE(bus_->next_wake()->ends_silence);  // the response timeout
  time_out();
  submit(job_of(1, kOther));
  EXPECT_FALSE(bus_->next_wake()->ends_silence);  // the quarantine
}

TEST_F(Bus, BytesThatAreNoFrameAreDrainedBeforeTheNextTransmission) {
  open(settings());
  line("12 34 56");
  EXPECT_EQ(bus_->parts().line.state(now_), bus::LineState::draining);
  submit(job(kRead));
  EXPECT_EQ(until_next_frame(10ms), kT35);
  line(kAnswer);
  EXPECT_EQ(bus_->parts().line.state(now_), bus::LineState::idle);
}

// 264 characters of 11 bits at 19200 take 151.25 ms.
TEST_F(Bus, KnowsTheLongestOrdinaryTransaction) {
  auto settling = settings();
  settling.timing.response_timeout = 700ms;
  settling.settle = 10ms;
  EXPECT_EQ(bus::longest_transaction(settling, {}), 861250us);
  drive::Device quick{"quick", {}, 1, settings().timing};
  quick.timing.response_wait = 50ms;
  quick.profile.slow = {{{}, 5s}};
  EXPECT_EQ(bus::longest_transaction(settling, std::vector{quick}), 311250us);
  settling.line.framing = bus::Framing::ascii;  // 513 characters and 16 take 303.073 ms
  const Duration ascii = bus::longest_transaction(settling, std::vector{quick});
  EXPECT_EQ(std::chrono::ceil<std::chrono::microseconds>(ascii), 463073us);
  settling.line.framing = bus::Framing::tcp;
  EXPECT_EQ(bus::longest_transaction(settling, std::vector{quick}), 150ms);
}

TEST_F(Bus, ShowsTheStatesOfTheSpecification) {
  auto listening = settings();
  listening.listen_first = 50ms;
  open(listening);
  using State = bus::LineState;
  EXPECT_EQ(bus_->parts().line.state(now_), State::initial);
  advance(50ms);
  EXPECT_EQ(bus_->parts().line.state(now_), State::idle);
  submit(job("06 0000 0001", 0));
  EXPECT_EQ(bus_->parts().line.state(now_), State::emission);
  advance(kEmission);
  EXPECT_EQ(bus_->parts().line.state(now_), State::waiting_turnaround_delay);
  advance(100ms);
  submit(job(kRead));
  advance(kEmission);
  EXPECT_EQ(bus_->parts().line.state(now_), State::waiting_for_reply);
}

TEST_F(Bus, ADeviceIsLeftAloneAfterAWriteAndTheOthersAreNot) {
  auto busy = settings();
  busy.timing.gap_after_write = 30ms;
  open(busy);
  submit(job("06 0000 0001"));
  advance(10ms);
  submit(job(kRead));
  line("01 06 00 00 00 01 48 0A");
  submit(job_of(1, kRead, 2));
  advance(10ms);
  ASSERT_THAT(frames_, SizeIs(2));
  EXPECT_EQ(frames_[1], kOtherDevice);
  line("02 03 02 12 34 F1 33");
  EXPECT_EQ(until_next_frame(), 20ms);
  EXPECT_EQ(frames_[2], kReadFrame);
}

}  // namespace
}  // namespace mbgate::test
