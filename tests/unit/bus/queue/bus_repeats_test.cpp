// SPDX-License-Identifier: Apache-2.0
// While something to one device waits for its next try, the others go on.
#include "stop_axis.hpp"
#include "unit/bus/bus_rig.hpp"

namespace mbgate::test::bus_repeats_test {
namespace {

constexpr auto kWrite = "06 0000 0001";

class BusRepeats : public Bus {
 protected:
  /// The devices that requests go to within `limit`; 1 and 8 are silent, others refuse after 10 ms.
  std::vector<int> served(Duration limit) {
    return Bus::served(limit, [this] { return answer(); });
  }
  void open_sharing() {
    auto sharing = settings();
    sharing.timing.retries = 1;
    sharing.coalesce = true;
    open(sharing);
  }
  int answer() {
    const auto request = unhex(frames_.back());
    if (request[0] != 1 && request[0] != 8 && request[0] != 0) {
      advance(9ms);
      refuse(request[0], request[1]);
    }
    return request[0];
  }
};

TEST_F(BusRepeats, AWriteToAnotherDeviceDoesNotWaitForTheRepetitionOfARead) {
  auto usual = settings();
  usual.timing = {};
  open(usual);
  submit(job_of(1, kRead));
  advance(100ms);
  bus::Job& write = job_of(2, kWrite, 2);
  submit(write);
  advance(1s);
  ASSERT_THAT(frames_, SizeIs(2));
  EXPECT_EQ(frames_[1], "02 06 00 00 00 01 48 39");
  EXPECT_LT(frame_times_[1] - frame_times_[0], 1010ms);
  advance(10ms);
  line("02 06 00 00 00 01 48 39");
  advance(1s);  // which others have had then
  ASSERT_THAT(frames_, SizeIs(3));
  EXPECT_EQ(frames_[2], frames_[0]);
}

TEST_F(BusRepeats, WithNobodyElseWaitingAReadIsRepeatedAtOnce) {
  open_retrying();
  submit(job(kRead));
  advance(kEmission + 100ms + kT35);
  EXPECT_THAT(frames_, SizeIs(2));
}

TEST_F(BusRepeats, OthersGoFirstUntilTheLostTimeIsPaidBack) {
  open_retrying();
  submit(job_of(0, kRead, 1));
  for (int times = 0; times < 3; ++times) {
    submit(job_of(1, kRead, 2));
    submit(job_of(2, kRead, 3));
  }
  EXPECT_EQ(answer(), 1);
  EXPECT_THAT(served(500ms), ElementsAre(2, 3, 2, 3, 2, 3, 1));
  EXPECT_GE(frame_times_.back() - frame_times_.front(), 2 * (kEmission + 100ms));
}

// A drive that is well is asked as often as it likes; others that are not take half of the time.
TEST_F(BusRepeats, SilentDevicesTakeHalfOfTheTimeAtMost) {
  auto usual = settings();
  usual.timing.retries = 1;
  usual.timing.offline_after = 0;
  open(usual);
  std::uint32_t next = 100;
  int reads_of_silent = 0;
  for (const Instant end = now_ + 10s; now_ < end; advance(10ms)) {
    for (const int address : {2, 1, 8}) {
      submit(job_of(next, kRead, static_cast<std::uint8_t>(address)));
      ++next;
    }
    if (unhex(frames_.back())[0] == 2) {
      refuse(2);
    }
  }
  for (const auto& frame : frames_) {
    reads_of_silent += unhex(frame)[0] == 2 ? 0 : 1;
  }
  EXPECT_LE(reads_of_silent * 100ms, 5100ms);
  EXPECT_GE(reads_of_silent * 100ms, 4000ms);
}

TEST_F(BusRepeats, TwoSilentDevicesTakeTurns) {
  open_retrying();
  for (int times = 0; times < 2; ++times) {
    submit(job_of(0, kRead, 1));
    submit(job_of(1, kRead, 8));
  }
  submit(job_of(2, kRead, 2));
  submit(job_of(2, kRead, 2));
  EXPECT_EQ(answer(), 1);
  EXPECT_THAT(served(400ms), ElementsAre(8, 2, 2, 1));
}

TEST_F(BusRepeats, WritesGoBeforeReadsBetweenTwoTries) {
  open_retrying();
  submit(job_of(0, kRead, 1));
  submit(job_of(1, kRead, 2));
  submit(job_of(2, kWrite, 3));
  EXPECT_EQ(answer(), 1);
  EXPECT_THAT(served(300ms), ElementsAre(3, 2, 1));
}

TEST_F(BusRepeats, TheTransactionsOfOneRequestStayTogether) {
  open_retrying();
  bus::Job& parts = job_of(0, kRead, 1);
  add(parts, "03 0010 0001", 1);
  submit(parts);
  submit(job_of(1, kWrite, 2));
  EXPECT_EQ(answer(), 1);
  EXPECT_THAT(served(300ms), ElementsAre(1, 2));
}

TEST_F(BusRepeats, NothingOfTheSameDeviceOvertakesTheRead) {
  open_retrying();
  submit(job_of(0, kRead, 1));
  submit(job_of(1, kWrite, 1));
  EXPECT_EQ(answer(), 1);
  advance(110ms);
  EXPECT_EQ(frames_.back(), frames_.front());
}

TEST_F(BusRepeats, ABroadcastOfAnotherClientMayGoBetweenTwoTriesItsOwnMayNot) {
  for (const std::uint32_t source : {0U, 1U}) {
    open_retrying();
    frames_.clear();
    submit(job_of(0, kRead, 1));
    submit(job_of(source, kWrite, 0));
    EXPECT_EQ(answer(), 1);
    EXPECT_THAT(served(400ms), source == 0 ? ElementsAre(1, 0) : ElementsAre(0, 1));
  }
}

TEST_F(BusRepeats, NorMayTheBroadcastOfAClientThatSharesTheRead) {
  open_sharing();
  submit(job_of(2, kRead, 2));
  submit(job_of(0, kRead, 1));
  submit(job_of(1, kRead, 1));
  submit(job_of(1, kWrite, 0));
  EXPECT_EQ(answer(), 2);
  EXPECT_THAT(served(600ms), ElementsAre(1, 1, 0));
}

TEST_F(BusRepeats, AStopIsNotTheTurnOfItsDevice) {
  auto retrying = settings();
  retrying.timing.retries = 1;
  retrying.timing.stop_retries = 0;
  open(retrying);
  submit(job_of(0, kRead, 1));
  submit(job_of(1, kRead, 2));
  EXPECT_EQ(answer(), 1);
  advance(60ms);
  bus::Job& stop = job_of(2, kWrite, 2);
  stop.job_class = bus::JobClass::stop;
  submit(stop);
  EXPECT_THAT(served(600ms), ElementsAre(2, 2, 1));
}

// The write may be repeated 20 ms after its timeout.
TEST_F(BusRepeats, AWriteThatIsRepeatedGoesBeforeReads) {
  auto repeating = settings();
  repeating.timing.retries = 1;
  repeating.timing.retry_writes = true;
  repeating.timing.quarantine = 0ms;
  open(repeating);
  submit(job_of(0, kRead, 1));
  submit(job_of(1, kWrite, 8));
  EXPECT_EQ(answer(), 1);
  for (std::uint8_t address = 2; address < 6; ++address) {
    submit(job_of(address, kRead, address));
  }
  EXPECT_THAT(served(600ms), ElementsAre(8, 2, 3, 8, 4, 5, 1));
}

TEST_F(BusRepeats, AReadOfADeviceThatABroadcastMadeBootGoesOnWhenItHas) {
  auto retrying = settings();
  retrying.timing.retries = 1;
  drive::Device booting{"booting", {}, 1, retrying.timing};
  booting.profile.broadcast.form = drive::BroadcastForm{};
  booting.profile.unanswered = {{{.address = 0, .mask = 0xFFFF, .value = 1}, 3s}};
  open(retrying, {booting});
  submit(job_of(0, kRead, 1));
  submit(job_of(1, kWrite, 0));
  EXPECT_EQ(answer(), 1);
  advance(kEmission + 100ms + kT35);
  ASSERT_THAT(frames_, SizeIs(2));  // the broadcast
  advance(4s);
  ASSERT_THAT(frames_, SizeIs(3));
  EXPECT_EQ(frames_[2], frames_[0]);
  EXPECT_EQ(frame_times_[2] - frame_times_[1], kEmission + 3s);
}

TEST_F(BusRepeats, ADeadlineThatPassesMeanwhileEndsTheRead) {
  open_retrying();
  bus::Job& read = job_of(0, kRead, 1);
  read.deadline = now_ + 150ms;
  submit(read);
  submit(job_of(1, kRead, 8));
  EXPECT_EQ(answer(), 1);
  advance(300ms);
  ASSERT_GE(endings_.size(), 1U);
  EXPECT_EQ(endings_[0], Ending::expired);
  EXPECT_EQ(ended_at_[0], read.deadline);
  EXPECT_EQ(std::ranges::count(frames_, frames_[0]), 1);
}

TEST_F(BusRepeats, ADeadlineThatPassesWhileAStopWaitsEndsTheRead) {
  auto retrying = settings();
  retrying.timing.retries = 1;
  drive::Device axis{"axis", {}, 9, retrying.timing};
  axis.profile.stops = {{.address = 0x007C, .value = 0x00E1}};
  open(retrying, {axis});
  bus::Job& read = job_of(0, kRead, 1);
  read.deadline = now_ + 150ms;
  submit(read);
  submit(job_of(1, kRead, 9));
  EXPECT_EQ(answer(), 1);
  advance(120ms);
  submit(job_of(2, "06 007C 00E1", 9));  // it lets the other read begin its answer for 100 ms
  advance(60ms);
  ASSERT_THAT(endings_, ElementsAre(Ending::expired));
  EXPECT_EQ(ended_at_[0], read.deadline);
}

TEST_F(BusRepeats, EachOfThoseThatShareTheReadHasItsOwnDeadline) {
  open_sharing();
  submit(job_of(0, kRead, 8));
  submit(job_of(1, kRead, 1));
  bus::Job& other = job_of(2, kRead, 1);
  other.deadline = now_ + 250ms;
  submit(other);
  submit(job_of(3, kRead, 7));
  advance(300ms);
  ASSERT_THAT(endings_, ElementsAre(Ending::expired));
  EXPECT_EQ(ended_at_[0], other.deadline);
}

TEST_F(BusRepeats, AfterStopNothingIsRepeated) {
  open_retrying();
  submit(job_of(0, kRead, 1));
  submit(job_of(1, kRead, 8));
  advance(110ms);
  bus_->stop(now_);
  drain();
  advance(1s);
  EXPECT_THAT(frames_, SizeIs(2));
}

TEST_F(BusRepeats, ARepeatedStopHasAsMuchTimeAsTheFirst) {
  open(settings(), {axis(settings(), 1), axis(settings(), 2), axis(settings(), 3)});
  for (const auto address : {1, 2, 3}) {
    submit(job_of(static_cast<std::uint32_t>(address), kStop, static_cast<std::uint8_t>(address)));
  }
  advance(2s);
  ASSERT_THAT(frames_, SizeIs(12));
  for (std::size_t at = 1; at < 12; ++at) {
    EXPECT_GE(frame_times_[at] - frame_times_[at - 1], 100ms) << at;
  }
}

// Payback never lets a read go before a write.
TEST_F(BusRepeats, AWriteDoesNotWaitWhileLostTimeIsPaidBack) {
  auto slow = settings();
  slow.timing.response_timeout = 1s;
  slow.timing.quarantine = 0ms;
  open(slow);
  const auto answered = [this](std::uint8_t address) {
    submit(job(kRead, address));
    advance(20ms);
    refuse(address);
    advance(10ms);
  };
  for (const std::uint8_t lost : std::array<std::uint8_t, 2>{3, 4}) {
    submit(job(kRead, lost));
    advance(1020ms);
    answered(2);
  }
  const std::size_t before = frames_.size();
  submit(job_of(1, kRead, 2));
  submit(job_of(2, "06 0001 0001", 3));
  advance(20ms);
  refuse(2);
  advance(20ms);
  EXPECT_EQ(frames_.at(before + 1).substr(0, 5), "03 06");
}

}  // namespace
}  // namespace mbgate::test::bus_repeats_test
