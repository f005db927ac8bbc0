// SPDX-License-Identifier: Apache-2.0
// Devices that were offline, and are back.
#include "offline_rig.hpp"

namespace mbgate::test {
namespace {

using Kind = bus::DeviceNotice::Kind;

TEST_F(BusOffline, OneResponseBringsItBack) {
  open(breaking());
  lose_device();
  advance(2s);
  submit(job(kRead));
  advance(20ms);
  line(kAnswer);
  EXPECT_THAT(notices_, ElementsAre(Kind::lost, Kind::back));
  EXPECT_FALSE(bus_->devices()[1].health.is_offline());
  advance(130ms);  // that may have answered what it was asked before: the next read shows it
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
  submit(job(kRead));
  line(kAnswer);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer, Ending::answered));
  advance(200ms);
  submit(job(kRead));
  submit(job_of(1, kRead));
  EXPECT_THAT(endings_, SizeIs(2));
}

// They may have got their supply back together.
TEST_F(BusOffline, WhereOneIsBackAfterALongTimeTheOthersAreAskedAtOnce) {
  for (const Duration offline : {5s, 11s}) {
    auto one = scarce();
    one.timing.offline_after = 1;
    open(one);
    for (const std::uint8_t address : std::initializer_list<std::uint8_t>{2, 1}) {
      submit(job(kRead, address));
      advance(300ms);
    }
    advance(offline);
    for (const std::uint8_t address : std::initializer_list<std::uint8_t>{2, 1}) {
      submit(job(kRead, address));
      advance(20ms);
      if (address == 1) {
        line(kAnswer);
      }
      advance(280ms);  // nothing holds it back any more
    }
    endings_.clear();
    submit(job(kRead, 3));
    submit(job(kRead, 2));
    EXPECT_EQ(endings_.empty(), offline == 11s);
  }
}

// It did not lose its supply, but did something else meanwhile. It answers in order, and quickly.
TEST_F(BusOffline, ADeviceThatWorksOffWhatItWasAskedGetsNothingUntilItIsSilent) {
  ask_beside_a_probe_with_a_late_answer();
  EXPECT_THAT(frames_, SizeIs(1));
  advance(10ms);
  for (int more = 0; more < 3; ++more) {
    line(kAnswer);
    advance(90ms);  // less than its response timeout
  }
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
  advance(40ms);
  EXPECT_THAT(frames_, SizeIs(2));
  advance(20ms);
  line(kAnswer);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer, Ending::answered));
}

// It would not show whose answer comes: to what was asked just before, or to this.
TEST_F(BusOffline, AReadOfOtherRegistersWaitsUntilTheProbeCannotBeAnswered) {
  ask_beside_a_probe_with_a_late_answer();
  advance(260ms);  // response timeout and quarantine, 20 ms for an adapter, and as long again
  EXPECT_THAT(frames_, SizeIs(1));
  advance(20ms);
  EXPECT_THAT(frames_, SizeIs(2));
}

// It was not without supply: it is slow, and owes two more answers.
TEST_F(BusOffline, ADeviceThatDoesNotAnswerTheProbeButAnOlderReadIsHeld) {
  open(breaking());
  lose_device();
  advance(2s);
  submit(job("06 0000 0001"));
  advance(20ms);
  line(kAnswer);
  submit(job(kRead));
  advance(1s);
  EXPECT_THAT(frames_, SizeIs(1));
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
}

TEST_F(BusOffline, AProbeWithALateAnswerIsRepeatedOnceForAShortTime) {
  auto retrying = breaking();
  open(retrying);
  lose_device();
  retrying.timing.retries = 1;
  update(retrying, {});
  advance(2s);
  submit(job(kRead));
  advance(20ms);
  line(kAnswer);
  advance(200ms);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
  EXPECT_THAT(frames_, SizeIs(2));
}

TEST_F(BusOffline, AReadShowsWhatAWriteAsTheProbeCannot) {
  open(breaking());
  lose_device();
  for (int times = 0; times < 2; ++times) {
    advance(2s);
    submit(job("06 0000 0001"));
    advance(20ms);
  }
  line("01 06 00 00 00 01 48 0A");  // of the first one, or the second
  advance(200ms);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer, Ending::no_answer));
  submit(job(kRead));
  advance(20ms);
  line(kAnswer);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer, Ending::no_answer, Ending::answered));
  submit(job("06 0000 0001"));
  advance(20ms);
  EXPECT_THAT(frames_, SizeIs(4));
}

TEST_F(BusOffline, WhatFollowsTheProbeInItsJobIsRepeatedAsEver) {
  auto retrying = breaking();
  open(retrying);
  lose_device();
  retrying.timing.retries = 1;
  update(retrying, {});
  advance(2s);
  bus::Job& both = job(kRead);
  add(both, kRead);
  submit(both);
  advance(20ms);
  line(kAnswer);
  advance(130ms);
  line(kAnswer);
  advance(500ms);
  EXPECT_THAT(frames_, SizeIs(4));
}

TEST_F(BusOffline, AnAnswerThatComesAfterTheProbesTimeBringsItBackToo) {
  open(breaking());
  lose_device();
  advance(2s);
  submit(job(kRead));
  advance(70ms);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
  line(kAnswer);
  EXPECT_FALSE(bus_->devices()[1].health.is_offline());
}

}  // namespace
}  // namespace mbgate::test
