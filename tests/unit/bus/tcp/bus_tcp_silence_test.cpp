// SPDX-License-Identifier: Apache-2.0
// Connections that take requests and bring nothing.
#include "bus_tcp_rig.hpp"

namespace mbgate::test {
namespace {

class BusTcpSilence : public BusTcp {
 protected:
  /// One read each second, each in its own right.
  void poll(Duration duration, std::uint8_t unit = 1) {
    for (const Instant end = now_ + duration; now_ < end;) {
      submit(job(kRead, unit));
      advance(1s);
    }
  }
};

TEST_F(BusTcpSilence, AConnectionFromWhichNothingComesIsReplaced) {
  open(tcp());
  submit(job(kRead));
  answer(0, "01 03 02 12 34");
  advance(10min);
  poll(5s);
  advance(30s - 5s - 1ns);
  EXPECT_THAT(replaced_, IsEmpty());
  advance(1ns);
  EXPECT_THAT(replaced_, ElementsAre(true));
  EXPECT_EQ(bus_->counters().losses, 1U);
  EXPECT_EQ(opens_, 1U);
  submit(job(kRead));
  EXPECT_EQ(opens_, 2U);
  reopen();
  answer(6, "01 03 02 12 34");
  EXPECT_EQ(endings_.back(), Ending::answered);
}

TEST_F(BusTcpSilence, FourUnansweredRequestsAreNotEnough) {
  open(tcp());
  poll(4s);
  advance(10min);
  EXPECT_THAT(replaced_, IsEmpty());
}

TEST_F(BusTcpSilence, ADeadDriveBehindALivingGatewayCostsNoConnection) {
  open(tcp());
  for (int times = 0; times < 10; ++times) {
    submit(job(kRead, 2));
    answer(frames_.size() - 1, "02 03 02 12 34");
    poll(29s, 1);
  }
  EXPECT_THAT(replaced_, IsEmpty());
}

TEST_F(BusTcpSilence, ItIsReplacedAtMostEvery30Seconds) {
  open(tcp());
  const Instant start = now_;
  std::vector<Instant> opened;
  while (now_ - start < 3min) {
    submit(job(kRead));
    advance(1s);
    if (opens_ > opened.size() + 1) {
      opened.push_back(now_);
      reopen();
    }
  }
  ASSERT_THAT(replaced_, ElementsAre(true, false, false, false, false));
  for (std::size_t i = 1; i < opened.size(); ++i) {
    EXPECT_GE(opened[i] - opened[i - 1], 30s);
  }
}

TEST_F(BusTcpSilence, WhatIsOnItsWayGoesToTheNextConnection) {
  auto patient = tcp(3);
  drive::Device slow{"slow", {}, 2, patient.timing};
  slow.timing.response_timeout = 1min;
  drive::Device other{"other", {}, 3, slow.timing};
  open(patient, {slow, other});
  poll(10s);
  submit(job(kRead, 2));
  submit(job("06 0000 0001", 3));
  advance(20s);
  EXPECT_THAT(replaced_, ElementsAre(true));
  EXPECT_EQ(endings_.back(), Ending::no_answer);  // the write
  EXPECT_EQ(opens_, 2U);
  reopen();
  EXPECT_EQ(units().back(), 2);
}

TEST_F(BusTcpSilence, WhatWasAskedBeforeTheLastByteDoesNotCount) {
  auto impatient = tcp(2);
  impatient.replace_after = 1;
  open(impatient);
  submit(job(kRead, 1));
  advance(50ms);
  submit(job(kRead, 2));
  answer(1, "02 03 02 12 34");
  advance(2min);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::no_answer));
  EXPECT_THAT(replaced_, IsEmpty());
  submit(job(kRead));
  advance(30s);
  EXPECT_THAT(replaced_, ElementsAre(true));
}

TEST_F(BusTcpSilence, ItIsKeptIfNobodyWantsItReplaced) {
  auto keeping = tcp();
  keeping.replace_after = 0;
  open(keeping);
  poll(2min);
  EXPECT_THAT(replaced_, IsEmpty());
}

}  // namespace
}  // namespace mbgate::test
