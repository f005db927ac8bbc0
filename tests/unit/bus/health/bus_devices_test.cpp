// SPDX-License-Identifier: Apache-2.0
// What a bus knows of its devices: slow registers, and writes that are never answered.
#include "unit/bus/bus_rig.hpp"

namespace mbgate::test {
namespace {

using modbus::Table;

constexpr auto kRestart = "06 00D4 0100";
constexpr auto kRestartFrame = "01 06 00 D4 01 00 C8 62";
constexpr auto kSave = "06 00DC 0001";

bus::BusSettings quick_turnaround(bus::BusSettings settings) {
  settings.turnaround = 40ms;
  settings.settle = 500ms;
  return settings;
}

// The restart of the RS-485 stepper, which boots for 3 s, and its save, which takes 1 s.
drive::Device stepper(const bus::BusSettings& settings, std::uint8_t address = 1) {
  drive::Device device{"stepper", {}, address, settings.timing};
  device.profile.unanswered = {{{Table::holding_registers, 0x00D4, 0xFF00, 0, true}, 3s}};
  device.profile.slow = {{{Table::holding_registers, 0x00DC, 1}, 1s}};
  return device;
}

TEST_F(Bus, WritesAndReadsOfSlowRegistersHaveALongerTimeout) {
  for (const auto* request :
       {kSave, "03 00DC 0001", "03 00D0 0010", "17 00DC 0001 0000 0001 02 0000"}) {
    endings_.clear();
    ended_at_.clear();
    open(settings(), {stepper(settings())});
    submit(job(request));
    const Instant start = now_;
    advance(10s);
    ASSERT_THAT(endings_, ElementsAre(Ending::no_answer)) << request;
    EXPECT_GE(ended_at_[0] - start, 1s) << request;
  }
}

TEST_F(Bus, ReadsBesideSlowRegistersHaveTheUsualTimeout) {
  open(settings(), {stepper(settings())});
  submit(job("03 00DD 0001"));
  const Instant start = now_;
  advance(2s);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
  EXPECT_EQ(ended_at_[0] - start, kEmission + 100ms);
}

TEST_F(Bus, AWriteThatIsNeverAnsweredIsDoneAfterTheTurnaroundDelay) {
  const auto quick = quick_turnaround(settings());
  open(quick, {stepper(quick)});
  submit(job(kRestart));
  const Instant start = now_;
  advance(1s);
  EXPECT_THAT(frames_, ElementsAre(kRestartFrame));
  EXPECT_THAT(endings_, ElementsAre(Ending::transmitted));
  EXPECT_EQ(ended_at_[0] - start, kEmission + 40ms);
  EXPECT_EQ(bus_->counters().timeouts, 0U);
  EXPECT_EQ(bus_->devices()[1].counters.timeouts, 0U);
  EXPECT_EQ(bus_->devices()[1].health.unanswered_in_row(), 0U);
}

TEST_F(Bus, ABootingDeviceIsHeldBackWhileOthersGoOn) {
  const auto quick = quick_turnaround(settings());
  open(quick, {stepper(quick)});
  submit(job(kRestart));
  submit(job(kRead, 1));
  submit(job(kRead, 2));
  const Instant silence = now_ + kEmission + 40ms;
  advance(kEmission + 40ms);
  EXPECT_THAT(frames_, ElementsAre(kRestartFrame, "02 03 00 00 00 01 84 39"));
  advance(5ms);
  line("02 03 02 12 34 F1 33");
  EXPECT_EQ(next_deadline(), silence + 3s);
  advance(5s);
  ASSERT_THAT(frames_, SizeIs(3));
  EXPECT_EQ(frames_[2], "01 03 00 00 00 01 84 0A");
  EXPECT_EQ(frame_times_[2], silence + 3s);
}

TEST_F(Bus, AWaitForABootingDeviceEndsAtTheDeadline) {
  open(settings(), {stepper(settings())});
  submit(job(kRestart));
  bus::Job& waiting = job(kRead);
  waiting.deadline = now_ + 1s;
  submit(waiting);
  const Instant start = now_;
  advance(5s);
  EXPECT_THAT(endings_, ElementsAre(Ending::transmitted, Ending::expired));
  EXPECT_EQ(ended_at_[1] - start, 1s);
  EXPECT_THAT(frames_, SizeIs(1));
}

TEST_F(Bus, AnExceptionToAWriteThatIsNeverAnsweredIsTaken) {
  open(settings(), {stepper(settings())});
  bus::Job& restart = job(kRestart);
  submit(restart);
  submit(job(kRead));
  advance(10ms);
  line("01 86 04 43 A3");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  EXPECT_EQ(hex(restart.transactions[0].response->bytes()), "86 04");
  EXPECT_EQ(until_next_frame(), kT35);
}

TEST_F(Bus, ADeviceThatAnswersBeforeItBootsIsHeldBackToo) {
  open(settings(), {stepper(settings())});
  submit(job(kRestart));
  submit(job(kRead));
  advance(10ms);
  line(kRestartFrame);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  EXPECT_EQ(until_next_frame(5s), 3s);
}

TEST_F(Bus, OtherWritesOfTheSameRegisterAreAnsweredAsUsual) {
  open(settings(), {stepper(settings())});
  submit(job("06 00D4 0001"));
  submit(job(kRestart, 2));  // this address has no such device
  advance(1s);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer, Ending::no_answer));
  EXPECT_EQ(bus_->counters().timeouts, 2U);
}

TEST_F(Bus, AJobGoesOnAfterAWriteThatIsNotAnsweredAndOnlyOtherDevicesPassIt) {
  const auto quick = quick_turnaround(settings());
  open(quick, {stepper(quick)});
  bus::Job& run = job(kRestart);
  add(run, "06 0000 0001");
  submit(run);
  bus::Job& other = job_of(1, kRead, 2);
  submit(other);
  bus::Job& same = job_of(2, kRead);
  submit(same);
  const Instant start = now_;
  advance(6s);
  EXPECT_THAT(frames_, ElementsAre("01 06 00 D4 01 00 C8 62", "02 03 00 00 00 01 84 39",
                                   "01 06 00 00 00 01 48 0A", "01 03 00 00 00 01 84 0A"));
  EXPECT_EQ(frame_times_[2] - start, kEmission + 40ms + 3s);
}

}  // namespace
}  // namespace mbgate::test
