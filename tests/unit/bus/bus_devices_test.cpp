// SPDX-License-Identifier: Apache-2.0
// What a bus knows of its devices: slow registers, writes that are never answered, contact.
#include "bus_rig.hpp"

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

TEST_F(Bus, WritesOfSlowRegistersHaveALongerTimeout) {
  open(settings(), {stepper(settings())});
  submit(job(kSave));
  const Instant start = now_;
  advance(2s);
  submit(job("03 00DC 0001"));
  advance(2s);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer, Ending::no_answer));
  EXPECT_EQ(ended_at_[0] - start, kEmission + 1s);
  EXPECT_EQ(ended_at_[1] - start, 2s + kEmission + 100ms);
}

TEST_F(Bus, ListensAsLongAsTheSlowestRegisterMayTake) {
  EXPECT_EQ(bus::longest_response_timeout(settings(), std::vector{stepper(settings())}), 1s);
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
  EXPECT_EQ(bus_->device_counters(1).timeouts, 0U);
  EXPECT_EQ(bus_->device_counters(1).unanswered_in_row, 0U);
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
  EXPECT_EQ(bus_->next_deadline(), silence + 3s);
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

TEST_F(Bus, AJobGoesOnAfterAWriteThatIsNotAnswered) {
  const auto quick = quick_turnaround(settings());
  open(quick, {stepper(quick)});
  bus::Job& run = job(kRestart);
  add(run, "06 0000 0001");
  submit(run);
  bus::Job& other = job_of(1, kRead, 2);
  submit(other);
  const Instant start = now_;
  advance(3500ms);  // nothing comes between, not even while the device boots
  ASSERT_THAT(frames_, SizeIs(2));
  EXPECT_EQ(frames_[1], "01 06 00 00 00 01 48 0A");
  EXPECT_EQ(frame_times_[1] - start, kEmission + 40ms + 3s);
}

TEST_F(Bus, ContactChangesWithSilenceAndWithTheLine) {
  open(settings(), {stepper(settings())});
  const auto first = bus_->contact(1);
  submit(job(kRead));
  line(kAnswer);
  advance(10ms);
  submit(job(kRead));
  line("01 83 02 C0 F1");
  EXPECT_EQ(bus_->contact(1), first);
  advance(10ms);
  const auto other = bus_->contact(2);
  submit(job(kRead));
  advance(1s);
  const auto silent = bus_->contact(1);
  EXPECT_NE(silent, first);
  EXPECT_EQ(bus_->contact(2), other);
  submit(job(kRestart));
  advance(1s);
  const auto restarted = bus_->contact(1);
  EXPECT_NE(restarted, silent);
  bus_->clear_counters();
  EXPECT_EQ(bus_->contact(1), restarted);
  bus_->handle_lost(now_);
  bus_->handle_opened(now_);
  EXPECT_NE(bus_->contact(1), restarted);
  EXPECT_NE(bus_->contact(2), other);
}

}  // namespace
}  // namespace mbgate::test
