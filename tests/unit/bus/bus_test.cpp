// SPDX-License-Identifier: Apache-2.0
// The times of a bus at 19200 8E1: a character takes 572.9 us, t3.5 is 2.005 ms, 8 characters 4.583
// ms.
#include "bus/bus.hpp"

#include <gmock/gmock.h>

#include "support/hex.hpp"

namespace mbgate::test {
namespace {

using namespace std::chrono_literals;
using bus::Duration;
using bus::Ending;
using bus::Instant;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

class Bus : public testing::Test {
 protected:
  void open(const bus::BusSettings& settings, const std::vector<drive::Device>& devices = {}) {
    bus_.emplace(settings, devices);
    bus_->start();
    bus_->handle_opened(now_);
    drain();
    advance(5ms);
  }
  static bus::BusSettings settings() {
    bus::BusSettings settings;
    settings.listen_first = 0ms;
    settings.timing.response_timeout = 100ms;
    settings.timing.retries = 0;
    return settings;
  }
  bus::Job& job(std::string_view request, std::uint8_t address = 1) {
    bus::Job& job = jobs_.emplace_back();
    job.deadline = now_ + 60s;
    add(job, request, address);
    return job;
  }
  static void add(bus::Job& job, std::string_view request, std::uint8_t address = 1) {
    const auto pdu = modbus::Pdu::from(unhex(request));
    job.transactions.push_back({address, *modbus::Request::parse(*pdu)});
  }
  void submit(bus::Job& job) {
    EXPECT_TRUE(bus_->submit(job, now_));
    drain();
  }
  void line(std::string_view bytes) {
    bus_->handle_bytes(unhex(bytes), now_);
    drain();
  }
  void advance(Duration duration) {
    const Instant end = now_ + duration;
    for (auto at = bus_->next_deadline(); at && *at <= end; at = bus_->next_deadline()) {
      now_ = std::max(now_, *at);
      bus_->handle_deadline(now_);
      drain();
    }
    now_ = end;
  }
  void drain() {
    while (const auto action = bus_->poll()) {
      if (const auto* transmit = std::get_if<bus::TransmitFrame>(&*action)) {
        frames_.push_back(hex({transmit->frame.data(), transmit->frame.size()}));
        frame_times_.push_back(now_);
      } else if (const auto* ended = std::get_if<bus::JobEnded>(&*action)) {
        endings_.push_back(ended->ending);
        ended_at_.push_back(now_);
      }
    }
  }
  /// From the last transmission on until the next one.
  Duration until_next_frame(Duration limit = 2s) {
    const std::size_t before = frames_.size();
    const Instant start = now_;
    advance(limit);
    return frames_.size() > before ? frame_times_[before] - start : Duration::max();
  }

  Instant now_{};
  std::deque<bus::Job> jobs_;
  std::optional<bus::Bus> bus_;
  std::vector<std::string> frames_;
  std::vector<Instant> frame_times_;
  std::vector<Ending> endings_;
  std::vector<Instant> ended_at_;
};

constexpr auto kRead = "03 0000 0001";
constexpr auto kAnswer = "01 03 02 12 34 B5 33";
constexpr auto kT35 = 2005209ns;       // 38.5 bits, rounded up
constexpr auto kEmission = 4583334ns;  // 88 bits, rounded up

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

TEST_F(Bus, ABadCrcIsRetriedForReadsOnly) {
  auto retrying = settings();
  retrying.timing.retries = 1;
  open(retrying);
  submit(job(kRead));
  advance(10ms);
  line("01 03 02 12 35 B5 33");
  advance(30ms);
  EXPECT_THAT(frames_, SizeIs(2));
  line(kAnswer);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  advance(10ms);
  submit(job("06 0000 0001"));
  advance(10ms);
  line("01 06 00 00 00 02 48 0A");
  advance(30ms);
  EXPECT_THAT(frames_, SizeIs(3));
  EXPECT_EQ(endings_.back(), Ending::no_answer);
  EXPECT_EQ(bus_->counters().bad_crcs, 2U);
}

TEST_F(Bus, SettlesAfterATimeoutBeforeTheNextRequest) {
  auto settling = settings();
  settling.settle = 50ms;
  open(settling);
  submit(job(kRead));
  submit(job(kRead, 2));
  advance(kEmission + 100ms);
  EXPECT_EQ(until_next_frame(), 50ms);
}

TEST_F(Bus, ReadsAndComparesItsEcho) {
  auto echoing = settings();
  echoing.line.echo = true;
  open(echoing);
  submit(job(kRead));
  EXPECT_THAT(frames_, ElementsAre("01 03 00 00 00 01 84 0A"));
  line("01 03 00 00");
  line("00 01 84 0A 01 03 02 12 34 B5 33");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  advance(20ms);
  submit(job("06 0000 0001"));  // its answer looks like its echo
  line("01 06 00 00 00 01 48 0A");
  EXPECT_THAT(endings_, SizeIs(1));
  line("01 06 00 00 00 01 48 0A");
  EXPECT_THAT(endings_, SizeIs(2));
  EXPECT_EQ(bus_->counters().echo_mismatches, 0U);
}

TEST_F(Bus, AnEchoThatDiffersIsCountedAndNotTakenForAnAnswer) {
  auto echoing = settings();
  echoing.line.echo = true;
  open(echoing);
  submit(job(kRead));
  line(kAnswer);
  EXPECT_THAT(endings_, IsEmpty());
  advance(1s);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
  EXPECT_EQ(bus_->counters().echo_mismatches, 1U);
}

TEST_F(Bus, AnEchoIsNoAnswerEvenIfNoiseCameBeforeIt) {
  auto echoing = settings();
  echoing.line.echo = true;
  open(echoing);
  submit(job("06 0010 0005"));
  line("FF");
  advance(1ms);
  line("01 06 00 10 00 05 48 0C");
  EXPECT_THAT(endings_, IsEmpty());
  advance(1s);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
}

TEST_F(Bus, SilenceThatWasAskedForIsNoTimeout) {
  auto settling = settings();
  settling.settle = 50ms;
  open(settling);
  bus::Job& listen_only = job("08 0004 0000");
  listen_only.transactions[0].silence_is_success = true;
  submit(listen_only);
  submit(job(kRead, 2));
  advance(kEmission + 100ms);
  EXPECT_THAT(endings_, ElementsAre(Ending::transmitted));
  EXPECT_THAT(frames_, SizeIs(2));
  EXPECT_EQ(bus_->counters().timeouts, 0U);
}

TEST_F(Bus, ABadCrcIsNoSilence) {
  open(settings());
  submit(job(kRead));
  advance(10ms);
  line("01 03 02 12 35 B5 33");
  advance(30ms);
  EXPECT_EQ(bus_->device_counters(1).bad_crcs, 1U);
  EXPECT_EQ(bus_->device_counters(1).unanswered_in_row, 0U);
}

TEST_F(Bus, ALineThatDiesAtOnceIsReopenedLessAndLessOften) {
  open(settings());
  std::vector<Duration> waits;
  for (int times = 0; times < 4; ++times) {
    bus_->handle_lost(now_);
    waits.push_back(*bus_->next_deadline() - now_);
    advance(waits.back());
    bus_->handle_opened(now_);
  }
  EXPECT_THAT(waits, ElementsAre(100ms, 200ms, 400ms, 800ms));
  advance(5s);
  bus_->handle_lost(now_);
  EXPECT_EQ(*bus_->next_deadline() - now_, 100ms);
}

TEST_F(Bus, ListensAsLongAsTheSlowestAddressMayTake) {
  auto slow_bus = settings();
  slow_bus.timing.response_timeout = 700ms;
  drive::Device quick{"quick", {}, 1, settings().timing};
  EXPECT_EQ(bus::longest_response_timeout(slow_bus, std::vector{quick}), 700ms);
}

TEST_F(Bus, LetsNothingComeBetweenTheTransactionsOfAJob) {
  open(settings());
  bus::Job& two = job(kRead);
  add(two, "03 0001 0001");
  submit(two);
  bus::Job& other = job(kRead, 9);
  other.source = bus::SourceId{1};
  submit(other);
  advance(10ms);
  line(kAnswer);
  advance(10ms);
  EXPECT_THAT(frames_, ElementsAre("01 03 00 00 00 01 84 0A", "01 03 00 01 00 01 D5 CA"));
  line(kAnswer);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  EXPECT_TRUE(two.transactions[0].response && two.transactions[1].response);
}

TEST_F(Bus, AnExceptionEndsAJobOfSeveralTransactions) {
  open(settings());
  bus::Job& two = job(kRead);
  add(two, "03 0001 0001");
  submit(two);
  line("01 83 02 C0 F1");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  EXPECT_EQ(hex(two.last_response()->bytes()), "83 02");
  advance(1s);
  EXPECT_THAT(frames_, SizeIs(1));
}

TEST_F(Bus, NoRetryBeginsAfterTheDeadline) {
  auto retrying = settings();
  retrying.timing.retries = 5;
  open(retrying);
  bus::Job& read = job(kRead);
  read.deadline = now_ + 150ms;
  submit(read);
  advance(10s);
  EXPECT_THAT(frames_, SizeIs(2));
  EXPECT_THAT(endings_, ElementsAre(Ending::expired));
  EXPECT_TRUE(read.was_on_wire);
}

TEST_F(Bus, WaitingJobsExpireAtTheirDeadlineToo) {
  open(settings());
  submit(job(kRead));
  bus::Job& waiting = job(kRead, 2);
  waiting.deadline = now_ + 20ms;
  submit(waiting);
  const Instant start = now_;
  advance(50ms);
  EXPECT_THAT(endings_, ElementsAre(Ending::expired));
  EXPECT_EQ(ended_at_[0] - start, 20ms);
  EXPECT_FALSE(waiting.was_on_wire);
}

TEST_F(Bus, CountsWhatADeviceDid) {
  open(settings());
  submit(job(kRead));
  advance(1s);
  submit(job(kRead));
  line("01 83 02 C0 F1");
  const auto& counters = bus_->device_counters(1);
  EXPECT_EQ(counters.transmissions, 2U);
  EXPECT_EQ(counters.timeouts, 1U);
  EXPECT_EQ(counters.responses, 1U);
  EXPECT_EQ(counters.exceptions, 1U);
  EXPECT_EQ(counters.unanswered_in_row, 0U);
}

TEST_F(Bus, ShowsTheStatesOfTheSpecification) {
  auto listening = settings();
  listening.listen_first = 50ms;
  open(listening);
  using State = bus::RtuLine::State;
  EXPECT_EQ(bus_->line_state(now_), State::initial);
  advance(50ms);
  EXPECT_EQ(bus_->line_state(now_), State::idle);
  submit(job("06 0000 0001", 0));
  EXPECT_EQ(bus_->line_state(now_), State::emission);
  advance(kEmission);
  EXPECT_EQ(bus_->line_state(now_), State::waiting_turnaround_delay);
  advance(100ms);
  submit(job(kRead));
  advance(kEmission);
  EXPECT_EQ(bus_->line_state(now_), State::waiting_for_reply);
}

}  // namespace
}  // namespace mbgate::test
