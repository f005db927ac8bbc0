// SPDX-License-Identifier: Apache-2.0
// Devices that do not answer: nobody waits for them, and one request now and then looks whether
// they are back.
#include "offline_rig.hpp"

namespace mbgate::test {
namespace {

using Kind = bus::DeviceNotice::Kind;

constexpr std::array<std::uint8_t, 3> kAddresses{1, 2, 3};

TEST_F(BusOffline, RetriesCountAndTheOthersWaitingAreAnsweredAtOnce) {
  auto retrying = breaking();
  retrying.timing.retries = 5;
  open(retrying);
  submit(job(kRead));
  submit(job_of(1, kRead));
  submit(job_of(2, "06 0000 0001"));
  submit(job_of(3, kRead, 2));
  advance(540ms);  // the two silent devices take turns
  EXPECT_THAT(notices_, ElementsAre(Kind::lost));
  EXPECT_THAT(endings_, ElementsAre(Ending::offline, Ending::offline, Ending::no_answer));
  EXPECT_FALSE(jobs_[2].was_on_wire);
  EXPECT_EQ(std::ranges::count(frames_, "01 03 00 00 00 01 84 0A"), 3);
  ASSERT_THAT(frames_, SizeIs(6));
  EXPECT_EQ(frames_[5], "02 03 00 00 00 01 84 39");
}

TEST_F(BusOffline, RequestsAreRefusedAtOnceButOneNowAndThenIsTheProbe) {
  open(breaking());
  lose_device();
  submit(job(kRead));
  EXPECT_THAT(endings_, ElementsAre(Ending::offline));
  EXPECT_THAT(frames_, IsEmpty());
  advance(2s);
  submit(job("06 0000 0001"));  // a write may be it too
  submit(job_of(1, kRead));
  EXPECT_THAT(endings_, ElementsAre(Ending::offline, Ending::offline));
  ASSERT_THAT(frames_, SizeIs(1));
  advance(kEmission + 100ms);
  EXPECT_THAT(endings_, ElementsAre(Ending::offline, Ending::offline, Ending::no_answer));
  EXPECT_EQ(ended_at_.back() - frame_times_[0], kEmission + 100ms);
  EXPECT_EQ(bus_->counters().probes, 1U);
}

TEST_F(BusOffline, ProbesTakeTheirShareOfTheTimeAndNoMore) {
  open(scarce());
  lose_device();
  advance(2s);
  const Instant start = now_;
  for (int request = 0; request < 6000; ++request) {
    if (request % 50 == 0) {
      submit(job_of(1, kRead, 2));  // somebody else asks
    }
    submit(job(kRead));
    advance(10ms);
    line("02 03 02 12 34 F1 33");
  }
  // 55 ms each and 2 percent: one in 2.7 s.
  EXPECT_EQ(now_ - start, 60s);
  EXPECT_EQ(std::ranges::count(frames_, "01 03 00 00 00 01 84 0A"), 22);
}

TEST_F(BusOffline, AShorterProbeLeavesTheShareOfALongerOne) {
  auto devices = usual_devices(scarce());
  devices[1].timing.probe_timeout = 10ms;
  open(scarce(), devices);
  lose_device();
  for (int times = 0; times < 3; ++times) {
    submit(job(kRead, 2));
    advance(300ms);
  }
  advance(10s);  // nobody else asks
  submit(job(kRead));
  submit(job(kRead, 2));
  advance(2190ms);
  submit(job_of(1, kRead, 3));
  advance(10ms);
  line("03 03 02 12 34 CC F3");
  EXPECT_THAT(endings_.back(), Ending::answered);
  submit(job(kRead));  // 55 ms and 2 percent: not before 2.7 s
  EXPECT_THAT(endings_.back(), Ending::offline);
}

TEST_F(BusOffline, AnAddressWithoutADeviceIsAfterOneUnansweredRequest) {
  auto usual = breaking();
  usual.timing.offline_after = 3;
  usual.timing.retries = 0;
  open(usual, {{"axis", {}, 1, usual.timing}});
  for (const std::uint8_t address : {std::uint8_t{1}, std::uint8_t{9}}) {
    submit(job(kRead, address));
    advance(300ms);
    EXPECT_EQ(bus_->devices()[address].health.is_offline(), address == 9);
  }
}

TEST_F(BusOffline, OfflineDevicesTakeTurns) {
  auto one = breaking();
  one.timing.offline_after = 1;
  open(one);
  for (const std::uint8_t address : kAddresses) {
    submit(job(kRead, address));
    advance(300ms);
  }
  frames_.clear();
  for (int request = 0; request < 2000; ++request) {
    for (const std::uint8_t address : kAddresses) {
      submit(job(kRead, address));
    }
    advance(10ms);
  }
  ASSERT_GE(frames_.size(), 6U);
  for (std::size_t at = 0; at < 6; ++at) {
    EXPECT_EQ(unhex(frames_[at])[0], 1 + at % 3) << at;
  }
}

/// Drives 1 to 30 are asked all the time, and none of them answers.
class BusOfThirty : public BusOffline {
 protected:
  void lose_all() {
    auto slow = settings();
    slow.line.baud = modbus::Baud{9600};
    slow.timing = {};
    open(slow);
    poll(200s);
    for (std::uint8_t address = 1; address <= 30; ++address) {
      EXPECT_TRUE(bus_->devices()[address].health.is_offline()) << int{address};
    }
  }
  /// Each is asked every `every_`, by a client that waits for the answer; `alive` answers.
  void poll(Duration duration, std::optional<std::uint8_t> alive = {}) {
    for (const Instant end = now_ + duration; now_ < end;) {
      for (std::uint8_t address = 1; address <= 30; ++address) {
        Poll& poll = polls_.at(address);
        if (now_ >= poll.next && (poll.job == nullptr || !poll.job->accepted)) {
          poll.job = &job_of(address, kRead, address);
          poll.next = now_ + every_;
          submit(*poll.job);
        }
      }
      advance(10ms);
      if (alive && polls_.at(*alive).job->sent.in_flight) {
        const auto answer = modbus::encode_rtu(*alive, *modbus::Pdu::from(unhex("83 02")));
        bus_->handle_bytes({answer.data(), answer.size()}, now_);
        drain();
        return;
      }
    }
  }
  struct Poll {
    bus::Job* job = nullptr;
    Instant next;
  };
  std::array<Poll, 31> polls_;
  Duration every_ = 1s;
};

TEST_F(BusOfThirty, OnAnIdleBusADriveThatIsSwitchedOnIsBackWithinTenSeconds) {
  lose_all();
  for (const std::uint8_t address : std::initializer_list<std::uint8_t>{1, 17, 30}) {
    const Instant since = now_;
    poll(60s, address);
    EXPECT_FALSE(bus_->devices()[address].health.is_offline()) << int{address};
    EXPECT_LT(now_ - since, 10s) << int{address};
    poll(30s);  // it is switched off again
  }
}

TEST_F(BusOfThirty, NobodyWaitsMuchLongerThanForASilentDevice) {
  lose_all();
  const std::size_t before = ended_at_.size();
  poll(20s);
  EXPECT_GT(ended_at_.size(), before);
  for (const bus::Job& job : jobs_) {
    EXPECT_TRUE(!job.accepted || now_ - job.accepted_at < 1200ms);
  }
}

TEST_F(BusOfThirty, WhoElseAsksWaitsForOneProbeAtMost) {
  lose_all();
  poll(1s);
  const Instant since = now_;
  submit(job_of(40, kRead, 40));
  advance(300ms);
  const auto sent = std::ranges::find_if(
      frames_, [](const std::string& frame) { return frame.starts_with("28 03"); });
  ASSERT_NE(sent, frames_.end());
  EXPECT_LT(frame_times_[static_cast<std::size_t>(sent - frames_.begin())] - since, 120ms);
}

// Whoever else asks waits for one probe at most.
TEST_F(BusOffline, BesideOtherRequestsOneProbeWaits) {
  auto one = breaking();
  one.timing.offline_after = 1;
  open(one);
  for (const std::uint8_t address : std::initializer_list<std::uint8_t>{1, 2}) {
    submit(job(kRead, address));
    advance(300ms);
  }
  advance(10s);
  submit(job_of(1, kRead, 3));  // occupies the line
  endings_.clear();
  submit(job(kRead, 1));
  EXPECT_THAT(endings_, IsEmpty());
  submit(job(kRead, 2));
  EXPECT_THAT(endings_, ElementsAre(Ending::offline));
}

TEST_F(BusOffline, AProbeThatWasTakenBackLeavesItsPlace) {
  open(breaking());
  lose_device();
  advance(2s);
  submit(job_of(1, kRead, 2));  // occupies the line
  bus::Job& probe = job(kRead);
  submit(probe);
  bus_->withdraw(probe);
  bus::Job& next = job(kRead);
  submit(next);
  EXPECT_TRUE(next.is_waiting());
}

// It takes its time of the line like one that gets no answer.
TEST_F(BusOffline, AProbeWhoseAnswerIsDamagedTakesItsShareOfTheTimeToo) {
  open(breaking());
  lose_device();
  advance(2s);
  submit(job(kRead));
  advance(20ms);
  line("01 03 02 12 35 B5 33");
  advance(100ms);
  EXPECT_TRUE(bus_->devices()[1].health.is_offline());
  submit(job(kRead));
  EXPECT_THAT(endings_.back(), Ending::offline);
  EXPECT_THAT(frames_, SizeIs(1));
}

TEST_F(BusOffline, AProbeThatFoundNoRoomIsNone) {
  auto small = breaking();
  small.queue = 1;
  open(small);
  lose_device();
  advance(2s);
  submit(job_of(1, kRead, 2));           // occupies the line
  submit(job_of(1, "06 0000 0001", 2));  // and the queue
  EXPECT_FALSE(bus_->submit(job(kRead), now_));
  advance(3s);
  submit(job(kRead));
  EXPECT_TRUE(jobs_.back().sent.in_flight);
}

TEST_F(BusOffline, BadCrcsSayNothingAboutIt) {
  open(breaking());
  for (int times = 0; times < 5; ++times) {
    submit(job(kRead));
    advance(10ms);
    line("01 03 02 12 35 B5 33");
    advance(220ms);
  }
  EXPECT_EQ(bus_->counters().bad_crcs, 5U);
  EXPECT_FALSE(bus_->devices()[1].health.is_offline());
}

}  // namespace
}  // namespace mbgate::test
