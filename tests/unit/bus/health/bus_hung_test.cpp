// SPDX-License-Identifier: Apache-2.0
// An adapter that takes what is transmitted while nothing is heard is closed and opened again.
#include "unit/bus/bus_rig.hpp"

namespace mbgate::test {
namespace {

class BusHung : public Bus {
 protected:
  void open_adapter(bus::LineKind kind, const bus::BusSettings& settings = Bus::settings()) {
    bus_.emplace(settings, std::vector<drive::Device>{});
    bus_->start();
    bus_->handle_opened(now_, kind);
    drain();
    advance(5ms);
  }
  void opened_again() {
    bus_->handle_opened(now_, bus::LineKind::uart);
    drain();
    advance(10ms);  // silence, and the next request
  }
  void submit_stop() {
    bus::Job& stop = job("06 007C 00E1");
    stop.job_class = bus::JobClass::stop;
    submit(stop);
  }
  /// Reads of that many devices that nobody answers.
  void ask_in_vain(unsigned requests) {
    for (unsigned i = 0; i < requests; ++i) {
      submit(job(kRead, static_cast<std::uint8_t>(100 + i)));
      advance(150ms);
    }
    EXPECT_THAT(endings_, SizeIs(requests));
    frames_.clear();
    endings_.clear();
  }
};

TEST_F(BusHung, IsReopenedAndWhatWaitsGoesAfterwards) {
  open_adapter(bus::LineKind::uart);
  ask_in_vain(10);
  advance(30s);
  EXPECT_FALSE(bus_->link().is_reopening()) << "nobody wants anything";
  submit(job(kRead));
  EXPECT_TRUE(bus_->link().is_reopening());
  EXPECT_THAT(frames_, IsEmpty());
  submit(job(kRead, 2));
  advance(3s);
  EXPECT_THAT(endings_, IsEmpty());
  opened_again();
  EXPECT_FALSE(bus_->link().is_reopening());
  EXPECT_THAT(frames_, SizeIs(1));
  advance(10ms);
  line(kAnswer);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  EXPECT_EQ(bus_->counters().losses, 0U);
}

TEST_F(BusHung, IsReopenedBetweenTheTriesOfARead) {
  auto settings = Bus::settings();
  open_adapter(bus::LineKind::adapter, settings);
  ask_in_vain(9);
  settings.timing.retries = 1;
  update(settings, {});
  advance(30s);
  submit(job(kRead));
  EXPECT_THAT(frames_, SizeIs(1)) << "the tenth request";
  advance(150ms);
  EXPECT_TRUE(bus_->link().is_reopening());
  opened_again();
  advance(100ms);  // the first one may still be answered
  EXPECT_THAT(frames_, SizeIs(2));
  advance(10ms);
  line(kAnswer);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
}

TEST_F(BusHung, IsNotReopenedAfterAByteOrOnAVirtualLine) {
  open_adapter(bus::LineKind::uart);
  ask_in_vain(10);
  line("00");
  advance(31s);
  submit(job(kRead));
  EXPECT_FALSE(bus_->link().is_reopening());
  open_adapter(bus::LineKind::virtual_line);
  endings_.clear();
  ask_in_vain(10);
  advance(31s);
  submit(job(kRead));
  EXPECT_FALSE(bus_->link().is_reopening());
}

TEST_F(BusHung, IsReopenedThoughAStopWaits) {
  open_adapter(bus::LineKind::uart);
  ask_in_vain(10);
  advance(30s);
  submit_stop();
  EXPECT_TRUE(bus_->link().is_reopening());
  EXPECT_THAT(frames_, IsEmpty());
  bus_->handle_opened(now_);
  drain();
  advance(5ms);
  EXPECT_THAT(frames_, SizeIs(1));
}

TEST_F(BusHung, StopsThatComeWhileItIsReopenedAndTheGatewayStopsGoAfterwards) {
  open_adapter(bus::LineKind::uart);
  ask_in_vain(10);
  advance(30s);
  submit(job(kRead));
  ASSERT_TRUE(bus_->link().is_reopening());
  bus_->stop(now_);
  submit_stop();
  opened_again();
  EXPECT_THAT(frames_, SizeIs(1));
  EXPECT_THAT(endings_, ElementsAre(Ending::cancelled)) << "the read";
}

TEST_F(BusHung, EndsWhatWaitsInTimeWhileItIsReopened) {
  open_adapter(bus::LineKind::uart);
  ask_in_vain(10);
  advance(30s);
  bus::Job& read = job(kRead);
  read.deadline = now_ + 1s;
  submit(read);
  ASSERT_TRUE(bus_->link().is_reopening());
  advance(1s);
  EXPECT_THAT(endings_, ElementsAre(Ending::expired));
}

TEST_F(BusHung, EndsWhatIsRepeatedInTimeWhileItIsReopened) {
  auto settings = Bus::settings();
  settings.timing.retries = 1;
  settings.hung_requests = 1;
  open_adapter(bus::LineKind::uart, settings);
  advance(30s);
  bus::Job& read = job(kRead);
  read.deadline = now_ + 1s;
  submit(read);
  advance(150ms);
  ASSERT_TRUE(bus_->link().is_reopening());
  EXPECT_THAT(endings_, IsEmpty());
  advance(1s);
  EXPECT_THAT(endings_, SizeIs(1));
}

TEST_F(BusHung, MayBeADeviceServerBehindTcp) {
  auto settings = Bus::settings();
  settings.line.remote = bus::Endpoint{"server", 4001};
  open_adapter(bus::LineKind::virtual_line, settings);
  ask_in_vain(10);
  advance(30s);
  submit(job(kRead));
  EXPECT_TRUE(bus_->link().is_reopening());
}

TEST_F(BusHung, IsLostIfItCannotBeOpenedAgain) {
  open_adapter(bus::LineKind::uart);
  ask_in_vain(10);
  advance(30s);
  submit(job(kRead));
  ASSERT_TRUE(bus_->link().is_reopening());
  bus_->handle_lost(now_);
  drain();
  EXPECT_FALSE(bus_->link().is_reopening());
  EXPECT_THAT(endings_, ElementsAre(Ending::closed));
}

TEST_F(BusHung, IsReopenedAtDoublingIntervals) {
  open_adapter(bus::LineKind::uart);
  std::vector<Duration> intervals;
  Instant opened = now_;
  while (intervals.size() < 4) {
    submit(job(kRead));
    advance(1s);
    if (bus_->link().is_reopening()) {
      intervals.push_back(std::chrono::duration_cast<std::chrono::seconds>(now_ - opened));
      opened_again();
      opened = now_;
    }
  }
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    EXPECT_GE(intervals[i], 30s * (1 << i));
    EXPECT_LE(intervals[i], 30s * (1 << i) + 2s);
  }
}

}  // namespace
}  // namespace mbgate::test
