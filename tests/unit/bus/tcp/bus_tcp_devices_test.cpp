// SPDX-License-Identifier: Apache-2.0
// Several transactions at a time on a connection: who shares a device, who has it alone.
#include "bus/tcp/tcp_discipline.hpp"
#include "bus_tcp_rig.hpp"

namespace mbgate::test {
namespace {

TEST_F(BusTcp, AWriteHasItsDeviceForItself) {
  open(tcp(4));
  submit(job_of(0, kRead, 1));
  submit(job_of(1, "06 0000 0001", 1));
  submit(job_of(2, kRead, 1));
  submit(job_of(3, kRead, 2));
  EXPECT_THAT(units(), ElementsAre(1, 2));  // the write waits for the read, the next read for it
  answer(0, "01 03 02 12 34");
  ASSERT_THAT(frames_, SizeIs(3));
  EXPECT_EQ(frames_[2], "00 03 00 00 00 06 01 06 00 00 00 01");
  submit(job_of(4, kRead, 1));
  EXPECT_THAT(frames_, SizeIs(3));
  answer(2, "01 06 00 00 00 01");
  EXPECT_THAT(units(), ElementsAre(1, 2, 1, 1, 1));
}

TEST_F(BusTcp, WhoAnswersWhatWasAskedLaterIsNotOffline) {
  auto breaking = tcp(2);
  breaking.timing.offline_after = 1;
  open(breaking);
  submit(job(kRead));
  advance(10ms);
  submit(job(kOther));
  answer(1, "01 03 02 12 34");
  advance(breaking.timing.response_timeout);
  EXPECT_FALSE(bus_->devices()[1].health.is_offline());
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::no_answer));
}

// What it owes is told apart by identifiers.
TEST_F(BusTcp, AReadAfterTheProbeHasTheWholeResponseTimeout) {
  auto breaking = tcp();
  breaking.timing.offline_after = 1;
  breaking.timing.probe_interval = 1s;
  open(breaking);
  for (const auto wait : {1100ms, 10ms}) {
    submit(job(kRead));
    advance(wait);
  }
  answer(1, "01 03 02 12 34");
  submit(job(kRead));
  advance(80ms);  // a probe waits for 50 ms
  answer(2, "01 03 02 12 34");
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer, Ending::answered, Ending::answered));
}

TEST_F(BusTcp, OfManyThatWereNotAnsweredTheNewestMayStillBe) {
  constexpr auto kMany = static_cast<unsigned>(bus::kMostAsked) + 1;
  auto breaking = tcp();
  breaking.timing.offline_after = kMany;
  breaking.replace_after = 0;
  open(breaking);
  for (unsigned times = 0; times < kMany; ++times) {
    submit(job(kRead));
    advance(breaking.timing.response_timeout);
  }
  EXPECT_TRUE(bus_->devices()[1].health.is_offline());
  answer(kMany - 1, "01 03 02 12 34");
  EXPECT_FALSE(bus_->devices()[1].health.is_offline());
}

TEST_F(BusTcp, WhatWasAskedBeforeAStopIsNotRemembered) {
  drive::Device axis{"axis", {}, 1, settings().timing};
  axis.cache = 1s;
  axis.profile.stops = {{.address = 7, .mask = 0, .value = 0}};
  open(tcp(2), {axis});
  submit(job_of(0, kRead, 1));
  submit(job_of(1, "06 0007 0001", 1));
  answer(1, "01 06 00 07 00 01");
  answer(0, "01 03 02 12 34");
  submit(job_of(1, kRead, 1));
  EXPECT_EQ(bus_->counters().cached_reads, 0U);
  EXPECT_THAT(units(), ElementsAre(1, 1, 1));
}

TEST_F(BusTcp, AWriteIsNotOutwaitedByReads) {
  open(tcp(2));
  submit(job_of(0, kRead, 1));
  submit(job_of(0, kRead, 1));
  submit(job_of(1, "06 0000 0001", 1));
  for (int times = 0; times < 3; ++times) {
    submit(job_of(0, kRead, 1));
  }
  answer(0, "01 03 02 12 34");
  EXPECT_THAT(frames_, SizeIs(2));
  answer(1, "01 03 02 12 34");
  ASSERT_THAT(frames_, SizeIs(3));
  EXPECT_EQ(frames_[2].substr(21, 2), "06");
}

TEST_F(BusTcp, AJobOfSeveralTransactionsHasItsDeviceForItself) {
  open(tcp(3));
  bus::Job& two = job(kRead, 1);
  add(two, "03 0001 0001", 1);
  submit(two);
  submit(job_of(1, kRead, 1));
  submit(job_of(1, kRead, 2));
  EXPECT_THAT(units(), ElementsAre(1, 2));
  answer(0, "01 03 02 11 11");
  EXPECT_THAT(units(), ElementsAre(1, 2, 1));
  EXPECT_EQ(frames_[2].substr(21), "03 00 01 00 01");
  answer(2, "01 03 02 22 22");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  EXPECT_THAT(units(), ElementsAre(1, 2, 1, 1));
  EXPECT_EQ(hex(two.transactions[0].response->bytes()), "03 02 11 11");
  EXPECT_EQ(hex(two.transactions[1].response->bytes()), "03 02 22 22");
}

TEST_F(BusTcp, ABootingDeviceIsHeldBackWhileOthersGoOn) {
  drive::Device booting{"booting", {}, 1, settings().timing};
  booting.profile.unanswered = {{{.address = 1, .mask = 0, .value = 0}, 3s}};
  open(tcp(2), {booting});
  submit(job("06 0001 0001", 1));
  submit(job(kRead, 1));
  submit(job(kRead, 2));
  EXPECT_THAT(units(), ElementsAre(1, 2));
  answer(1, "02 03 02 12 34");
  const Instant start = now_;
  advance(5s);
  EXPECT_THAT(units(), ElementsAre(1, 2, 1));
  EXPECT_EQ(frame_times_[2] - start, 100ms + 3s);  // a connection has no turnaround delay
  EXPECT_EQ(endings_[1], Ending::transmitted);
}

TEST_F(BusTcp, AGapHoldsBackItsDevice) {
  drive::Device gapped{"gapped", {}, 1, settings().timing};
  gapped.timing.gap = 30ms;
  for (const bool is_answered : {true, false}) {
    frames_.clear();
    frame_times_.clear();
    open(tcp(2), {gapped});
    submit(job(kRead, 2));
    submit(job(kRead, 1));
    if (is_answered) {
      advance(20ms);
      answer(0, "02 03 02 12 34");
    }
    EXPECT_EQ(until_next_frame(), 30ms);
  }
}

TEST_F(BusTcp, LateAnswersAreKnownByTheIdentifiersOfTheLast64Timeouts) {
  open(tcp());
  for (std::size_t times = 0; times <= bus::kMostAsked; ++times) {
    submit(job(kRead));
    advance(100ms);
  }
  ASSERT_THAT(endings_, SizeIs(1 + bus::kMostAsked));
  answer(1, "01 03 02 12 34");
  EXPECT_EQ(bus_->counters().late_responses, 1U);
  answer(0, "01 03 02 12 34");
  EXPECT_EQ(bus_->counters().late_responses, 1U);
}

TEST_F(BusTcp, WhatALostConnectionOwedIsNotWaitedForOnTheNextOne) {
  auto slow = tcp();
  slow.timing.quarantine = 10s;
  open(slow);
  const auto time_out = [this] {
    submit(job(kRead));
    advance(100ms);
  };
  time_out();
  submit(job(kRead));
  bus_->handle_lost(now_);
  bus_->handle_opened(now_);
  time_out();
  answer(2, "01 03 02 12 34");
  time_out();
  answer(3, "01 03 02 12 34");
  EXPECT_EQ(bus_->counters().late_responses, 2U);
  EXPECT_EQ(bus_->counters().foreign_frames, 0U);
}

// Its transaction identifier was this gateway's.
TEST_F(BusTcp, AnAnswerIsNobodyElsesHoweverLateItIs) {
  open(tcp());
  advance(11s);
  submit(job(kRead));
  advance(11s);  // longer than quarantine_max
  answer(0, "01 03 02 12 34");
  EXPECT_EQ(bus_->counters().unsolicited_frames, 1U);
  EXPECT_EQ(bus_->counters().foreign_frames, 0U);
  EXPECT_EQ(bus_->diagnosis().last_foreign(), Instant::min());
  EXPECT_THAT(notices_, IsEmpty());
}

TEST_F(BusTcp, AnswersAfterALostConnectionAreNoLaterForIt) {
  auto slow = tcp();
  slow.timing.quarantine = 10s;
  open(slow);
  submit(job(kRead));
  advance(100ms);
  submit(job(kRead));
  bus_->handle_lost(now_);
  bus_->handle_opened(now_);
  for (const std::size_t frame : {2U, 3U}) {
    submit(job(kRead));
    answer(frame, "01 03 02 12 34");
  }
  EXPECT_EQ(bus_->counters().responses, 2U);
}

// On a connection there are no broadcasts, and unit 0 is as others are.
TEST_F(BusTcp, ADriveAtUnitZeroIsAnotherWithAnotherName) {
  drive::Device device{"axis", {}, 0, tcp().timing};
  open(tcp(), {device});
  bus::Job& read = job(kRead, 0);
  read.transactions[0].broadcast.reset();
  submit(read);
  answer(0, "00 03 02 12 34");
  EXPECT_EQ(bus_->devices()[0].health.state(), bus::DeviceState::answering);
  device.name = "other";
  update(tcp(), {device});
  EXPECT_EQ(bus_->devices()[0].health.state(), bus::DeviceState::not_asked);
  EXPECT_FALSE(bus_->diagnosis().quality()[0].has_answered());
}

}  // namespace
}  // namespace mbgate::test
